//! Scenes by the hash of their bytes, decoded.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::sync::{Arc, Mutex, PoisonError};

use scene::{AssetHash, Scene};
use store::Store;
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use crate::ServerError;
use crate::limits::MAX_SCENES_KEPT;
use crate::storage::Storage;

/// How a demo scene is named.
pub const DEMO: &str = "demo:";

/// Decodes scenes, one at a time as each may take gigabytes, and keeps the latest.
#[derive(Debug)]
pub struct Scenes {
    storage: Storage,
    /// The latest used at the end. Never held while a scene is decoded.
    kept: Mutex<Vec<(AssetHash, Arc<Scene>)>>,
    decoding: Semaphore,
}

impl Scenes {
    /// None is decoded yet.
    pub fn new(storage: Storage) -> Self {
        Self { storage, kept: Mutex::default(), decoding: Semaphore::new(1) }
    }

    /// The asset that `name` means, known to decode: `demo:NAME` or `sha256:HEX`.
    pub async fn resolve(&self, name: &str) -> Result<AssetHash, ServerError> {
        let asset = match name.strip_prefix(DEMO) {
            Some(demo) => {
                let no_demo = || ServerError::NoDemo(demo.chars().take(64).collect());
                self.storage.put_asset(assets::demo_bytes(demo).ok_or_else(no_demo)?).await?
            }
            None => name.parse().map_err(protocol::Refused::from)?,
        };
        self.load(asset).await?;
        Ok(asset)
    }

    /// Keeps a scene's file once it is known to decode.
    pub async fn add(&self, file: File) -> Result<AssetHash, ServerError> {
        let turn = self.decoding.acquire().await.map_err(|_| ServerError::Fault)?;
        let folder = self.storage.folder().to_owned();
        let decoded = spawn_blocking(move || {
            let bytes = read_all(file).map_err(|reason| ServerError::Data { path: folder, reason })?;
            let loaded = assets::load_bytes(&bytes)?;
            Ok::<_, ServerError>((bytes, loaded.scene))
        });
        let (bytes, scene) = decoded.await.map_err(|_| ServerError::Fault)??;
        drop(turn);
        let asset = self.storage.put_asset(bytes).await?;
        self.keep(asset, &Arc::new(scene));
        Ok(asset)
    }

    /// The scene of those bytes.
    pub async fn load(&self, asset: AssetHash) -> Result<Arc<Scene>, ServerError> {
        if let Some(scene) = self.kept(&asset) {
            return Ok(scene);
        }
        let _turn = self.decoding.acquire().await.map_err(|_| ServerError::Fault)?;
        // Whoever had the turn before may have wanted the same.
        if let Some(scene) = self.kept(&asset) {
            return Ok(scene);
        }
        let storage = self.storage.clone();
        let decoded = spawn_blocking(move || decode(&storage.open().map_err(ServerError::Unread)?, &asset));
        let scene = decoded.await.map_err(|_| ServerError::Fault)??;
        self.keep(asset, &scene);
        Ok(scene)
    }

    /// As [`Self::load`], for threads that may block.
    pub fn find(&self, asset: &AssetHash) -> Result<Arc<Scene>, ServerError> {
        if let Some(scene) = self.kept(asset) {
            return Ok(scene);
        }
        let store = self.storage.open().map_err(ServerError::Unread)?;
        let scene = decode(&store, asset)?;
        self.keep(*asset, &scene);
        Ok(scene)
    }

    fn kept(&self, asset: &AssetHash) -> Option<Arc<Scene>> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let index = kept.iter().position(|(known, _)| known == asset)?;
        let found = kept.remove(index);
        let scene = Arc::clone(&found.1);
        kept.push(found);
        Some(scene)
    }

    fn keep(&self, asset: AssetHash, scene: &Arc<Scene>) {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept.retain(|(known, _)| *known != asset);
        if kept.len() == MAX_SCENES_KEPT {
            kept.remove(0);
        }
        kept.push((asset, Arc::clone(scene)));
    }
}

fn read_all(mut file: File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads and decodes a stored scene. Blocks.
fn decode(store: &Store, asset: &AssetHash) -> Result<Arc<Scene>, ServerError> {
    let unknown = || edit::Refusal::Edit(scene::EditError::UnknownAsset(*asset));
    let bytes = store.asset(asset).map_err(ServerError::Unread)?.ok_or_else(unknown)?;
    let loaded = assets::load_bytes(&bytes)?;
    for note in loaded.notes {
        tracing::info!("{asset}: {note}");
    }
    Ok(Arc::new(loaded.scene))
}

//! Decoded scenes, by the hash of their bytes.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::sync::{Arc, Mutex, PoisonError};

use assets::LoadedScene;
use document::{AssetHash, CommandContext, CommandSolution, Document, EditError, SceneContents};
use protocol::Asset;
use raycast::Bvh;
use scene::PosedScene;
use store::Store;
use tokio::sync::{Mutex as AsyncMutex, OnceCell, Semaphore};

use crate::ServerError;
use crate::background;
use crate::limits::MAX_CACHED_SCENES;
use crate::metrics::Metrics;
use crate::pacing::UploadPacing;
use crate::storage::Storage;
use crate::views::MovingPixels;

/// Prefix of demo scenes.
pub const DEMO: &str = "demo:";
/// Number of primitives above which the notes warn of them, since each is a separate draw.
const MANY_PRIMITIVES: usize = 10_000;
/// Number of triangles over one another above which the notes warn of them ([`PosedScene::depth_complexity`]). Modeled
/// scenes have some dozens.
const MANY_OVERLAPPING_TRIANGLES: f64 = 1_000.0;
/// Number of digits of its hash in the name of an unnamed scene.
const UNNAMED_HASH_DIGITS: usize = 8;

/// A scene decoded from its bytes.
#[derive(Clone, Debug, Default)]
pub struct DecodedScene {
    /// Geometry and materials, posed.
    pub posed: Arc<PosedScene>,
    /// Lights and cameras of the file.
    pub contents: Arc<SceneContents>,
    /// Parts of the file that are not drawn or were changed, one sentence each.
    pub notes: Arc<[String]>,
    /// Name of the scene in its own file.
    embedded_name: Option<String>,
    /// BVH of the scene, made at first use and shared by all clones.
    bvh: Arc<OnceCell<Arc<Bvh>>>,
}

/// Decodes scenes, one at a time since each may take gigabytes, and caches the latest.
#[derive(Debug)]
pub struct SceneCache {
    storage: Storage,
    /// Most recently used last. Never locked while a scene is decoded.
    cache: Mutex<Vec<(AssetHash, DecodedScene)>>,
    decoding: Arc<Semaphore>,
    uploads: Arc<AsyncMutex<UploadPacing>>,
    metrics: Arc<Metrics>,
}

impl SceneCache {
    pub fn new(storage: Storage, metrics: Arc<Metrics>, moving: Arc<MovingPixels>) -> Self {
        Self {
            storage,
            cache: Mutex::default(),
            decoding: Arc::new(Semaphore::new(1)),
            uploads: Arc::new(AsyncMutex::new(UploadPacing::new(moving))),
            metrics,
        }
    }

    /// Resolves `demo:NAME` or `sha256:HEX` to an asset that decodes, and returns its display name.
    pub async fn resolve(&self, reference: &str) -> Result<(AssetHash, String), ServerError> {
        let asset = match reference.strip_prefix(DEMO) {
            Some(demo) => {
                let no_demo = || ServerError::NoDemo(demo.chars().take(64).collect());
                self.storage.put_asset(assets::demo_bytes(demo).ok_or_else(no_demo)?).await?
            }
            None => reference.parse().map_err(protocol::Refused::from)?,
        };
        let decoded = self.load(asset).await?;
        Ok((asset, self.name_of(asset, &decoded).await?))
    }

    /// Stores a scene's file after it was decoded, with `name` as its name if given.
    pub async fn add(&self, file: File, name: Option<String>) -> Result<Asset, ServerError> {
        let turn = Arc::clone(&self.uploads).lock_owned().await;
        let folder = self.storage.folder().to_owned();
        let decode = move || {
            let bytes = read_all(file).map_err(|reason| ServerError::Data { path: folder, reason })?;
            let decoded = DecodedScene::of(&bytes)?;
            Ok::<_, ServerError>((bytes, decoded))
        };
        let (decoded, permit) = UploadPacing::run(turn, &self.decoding, decode).await?;
        let (bytes, decoded) = decoded?;
        self.metrics.scenes_decoded.inc();
        drop(permit);
        let asset = self.storage.put_asset(bytes).await?;
        if let Some(name) = name {
            self.storage.name_asset(asset, name).await?;
        }
        self.cache_scene(asset, &decoded);
        let name = self.name_of(asset, &decoded).await?;
        Ok(Asset { asset: asset.to_string(), name, notes: decoded.notes.to_vec() })
    }

    /// Returns the display name of a scene: the name that a user gave it, or the name in the file, or the start of its
    /// hash.
    async fn name_of(&self, asset: AssetHash, decoded: &DecodedScene) -> Result<String, ServerError> {
        let named = self.storage.read(move |store| store.assets.name_of(&asset)).await?;
        let own = || decoded.embedded_name.clone();
        Ok(named.or_else(own).unwrap_or_else(|| format!("scene {}", &asset.hex()[..UNNAMED_HASH_DIGITS])))
    }

    /// Returns the scene of that hash, from the cache or decoded.
    pub async fn load(&self, asset: AssetHash) -> Result<DecodedScene, ServerError> {
        if let Some(scene) = self.cached(&asset) {
            return Ok(scene);
        }
        let permit = Arc::clone(&self.decoding).acquire_owned().await.map_err(|_| ServerError::Internal)?;
        // The previous holder of the permit may have decoded the same scene.
        if let Some(scene) = self.cached(&asset) {
            return Ok(scene);
        }
        let storage = self.storage.clone();
        let decode = move || decode(&storage.open().map_err(ServerError::StoreRead)?, &asset);
        let (decoded, _permit) = background::run_with(permit, decode).await?;
        let decoded = decoded?;
        self.metrics.scenes_decoded.inc();
        self.cache_scene(asset, &decoded);
        Ok(decoded)
    }

    /// Returns the scene of a document, or an empty one if it has none.
    pub async fn of(&self, document: &Document) -> Result<DecodedScene, ServerError> {
        match document.scene() {
            Some(scene) => self.load(scene.asset).await,
            None => Ok(DecodedScene::default()),
        }
    }

    fn cached(&self, asset: &AssetHash) -> Option<DecodedScene> {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        let index = cache.iter().position(|(known, _)| known == asset)?;
        cache[index..].rotate_left(1);
        cache.last().map(|(_, decoded)| decoded.clone())
    }

    fn cache_scene(&self, asset: AssetHash, decoded: &DecodedScene) {
        let mut cache = self.cache.lock().unwrap_or_else(PoisonError::into_inner);
        cache.retain(|(known, _)| *known != asset);
        if cache.len() == MAX_CACHED_SCENES {
            cache.remove(0);
        }
        cache.push((asset, decoded.clone()));
    }
}

impl DecodedScene {
    /// Decodes a scene's file.
    fn of(bytes: &[u8]) -> Result<Self, ServerError> {
        let LoadedScene { scene, contents, name, notes } = assets::load_bytes(bytes)?.with_default_light();
        let (posed, contents) = (scene::pose(scene, 0.0), Arc::new(contents));
        let notes = notes.into_iter().chain(performance_notes(&posed)).collect();
        Ok(Self { posed, contents, notes, embedded_name: name, bvh: Arc::default() })
    }

    /// Makes the context of a command: the bounds of this scene, the contents of the scene that the command loads, and
    /// the solution of the command.
    pub fn context<'a>(
        &self,
        loaded: Option<&'a SceneContents>,
        solved: Option<&'a CommandSolution>,
    ) -> CommandContext<'a> {
        CommandContext { scene_bounds: self.posed.bounds(), loaded, solved }
    }

    /// Returns the BVH for rays. It is built on first use in the background, once for all clones of the scene, even if
    /// the first asker is gone.
    pub async fn bvh(&self) -> Result<Arc<Bvh>, ServerError> {
        let (bvh, posed) = (Arc::clone(&self.bvh), Arc::clone(&self.posed));
        let built = tokio::spawn(async move {
            let build = || background::run(move || Arc::new(Bvh::new(posed)));
            bvh.get_or_try_init(build).await.map(Arc::clone)
        });
        built.await.map_err(|_| ServerError::Internal)?
    }
}

/// Lists reasons why pictures of the scene are slow, one sentence each.
fn performance_notes(posed: &PosedScene) -> impl Iterator<Item = String> + use<> {
    let (count, depth) = (posed.primitives.len(), posed.depth_complexity());
    let primitives = (count > MANY_PRIMITIVES).then(|| {
        format!("the scene has {count} primitives, so its pictures take long: join those that share a material")
    });
    let depth = (depth > MANY_OVERLAPPING_TRIANGLES).then(|| {
        let sheets = depth.round();
        format!("in one place of the scene {sheets} triangles lie over one another, so its pictures take long: leave out what is hidden")
    });
    primitives.into_iter().chain(depth)
}

fn read_all(mut file: File) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.rewind()?;
    file.read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads and decodes a stored scene. Blocks.
fn decode(store: &Store, asset: &AssetHash) -> Result<DecodedScene, ServerError> {
    let bytes = store.assets.bytes(asset).map_err(ServerError::StoreRead)?.ok_or(EditError::UnknownAsset(*asset))?;
    DecodedScene::of(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn the_bvh_is_built_once_for_all_clones_of_a_scene() {
        let decode = || DecodedScene::of(&assets::demo_bytes("vases").expect("a demo")).expect("a scene");
        let decoded = decode();
        let other = decoded.clone();
        let (one, two) = tokio::join!(decoded.bvh(), other.bvh());
        let (one, two) = (one.expect("built"), two.expect("built"));
        assert!(Arc::ptr_eq(&one, &two) && Arc::ptr_eq(&one.posed, &decoded.posed));
        // Deliberate fault that the check must detect: the same scene decoded again has its own BVH.
        assert!(!Arc::ptr_eq(&one, &decode().bvh().await.expect("built")));
    }
}

//! Assets: a file each, named by the hash of its bytes.

use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::PathBuf;

use scene::AssetHash;

use crate::database::sync_folder;
use crate::{Store, StoreError};

/// Bytes that an asset has at most. The largest scene that can be read, 512 MiB, with its pictures in base64 takes 683.
pub const MAX_ASSET_BYTES: u64 = 768 << 20;

/// How the name of a file begins that is not whole yet.
const LEFTOVER: &str = ".incoming-";

impl Store {
    /// Keeps the bytes. They are on the disk when this returns; where they are already, nothing is written.
    pub fn put_asset(&self, bytes: &[u8]) -> Result<AssetHash, StoreError> {
        if bytes.len() as u64 > MAX_ASSET_BYTES {
            return Err(StoreError::AssetTooLarge);
        }
        let asset = AssetHash::of(bytes);
        if let Ok(Some(_)) = self.asset(&asset) {
            return Ok(asset);
        }
        self.write(&asset, bytes).map_err(|reason| self.failed(&asset, reason))?;
        Ok(asset)
    }

    /// The bytes of that hash; `None` where they are not here.
    pub fn asset(&self, asset: &AssetHash) -> Result<Option<Vec<u8>>, StoreError> {
        let bytes = match self.read(asset) {
            Ok(bytes) => bytes,
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(reason) => return Err(self.failed(asset, reason)),
        };
        if AssetHash::of(&bytes) == *asset { Ok(Some(bytes)) } else { Err(StoreError::DamagedAsset(*asset)) }
    }

    /// At most one byte over the limit, which no hash can match then.
    fn read(&self, asset: &AssetHash) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        File::open(self.asset_path(asset))?.take(MAX_ASSET_BYTES + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// First beside its place, so that a file of that name is always whole.
    fn write(&self, asset: &AssetHash, bytes: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.assets)?;
        let mut file = tempfile::Builder::new().prefix(LEFTOVER).tempfile_in(&self.assets)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(self.asset_path(asset))?;
        sync_folder(&self.assets)
    }

    /// Removes what was left of assets whose writing was cut off. Only while nobody else writes assets.
    pub fn remove_leftovers(&self) -> Result<(), StoreError> {
        let removed = fs::read_dir(&self.assets).and_then(|files| {
            for file in files {
                let file = file?;
                if file.file_name().to_string_lossy().starts_with(LEFTOVER) {
                    fs::remove_file(file.path())?;
                }
            }
            Ok(())
        });
        removed.map_err(|reason| StoreError::Io { path: self.assets.clone(), reason })
    }

    fn asset_path(&self, asset: &AssetHash) -> PathBuf {
        self.assets.join(asset.hex())
    }

    fn failed(&self, asset: &AssetHash, reason: io::Error) -> StoreError {
        StoreError::Io { path: self.asset_path(asset), reason }
    }
}

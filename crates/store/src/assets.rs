//! Assets: a file each, named by the hash of its bytes, and beside it what people call it.

use std::fs::{self, DirBuilder, File};
use std::io::{self, Read, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use document::AssetHash;
use light::MAX_NAME_BYTES;

use crate::StoreError;
use crate::disk::sync_folder;
use crate::limits::MAX_ASSET_BYTES;

/// The folder of assets in the data folder.
pub(crate) const ASSETS_FOLDER: &str = "assets";
/// How the name of the file ends that holds what people call an asset.
const NAME_SUFFIX: &str = ".name";
/// How the name of a file begins that is not whole yet.
const PARTIAL_PREFIX: &str = ".incoming-";

/// The assets of a data folder.
#[derive(Clone, Debug)]
pub struct Assets {
    folder: PathBuf,
}

impl Assets {
    /// Those in the data folder `data`, which may hold nothing else, or not be there.
    pub fn in_folder(data: &Path) -> Self {
        Self { folder: data.join(ASSETS_FOLDER) }
    }

    /// Those in the data folder `data`, which must have some place for them.
    pub fn open(data: &Path) -> Result<Self, StoreError> {
        check_folder(data)?;
        let assets = Self::in_folder(data);
        if assets.folder.is_dir() { Ok(assets) } else { Err(StoreError::NoAssets(data.into())) }
    }

    /// Makes their folder where it is missing.
    pub(crate) fn make_folder(&self) -> Result<(), StoreError> {
        let made = DirBuilder::new().recursive(true).mode(0o700).create(&self.folder);
        made.map_err(|reason| StoreError::Io { path: self.folder.clone(), reason })
    }

    /// Keeps the bytes. They are on the disk when this returns; where they are already, nothing is written.
    pub fn put(&self, bytes: &[u8]) -> Result<AssetHash, StoreError> {
        if bytes.len() as u64 > MAX_ASSET_BYTES {
            return Err(StoreError::AssetTooLarge);
        }
        let asset = AssetHash::of(bytes);
        if let Ok(Some(_)) = self.bytes(&asset) {
            return Ok(asset);
        }
        let path = self.path(&asset);
        self.write(&path, bytes).map_err(|reason| StoreError::Io { path, reason })?;
        Ok(asset)
    }

    /// Keeps what people call an asset, in place of an earlier name. It is on the disk when this returns.
    pub fn set_name(&self, asset: &AssetHash, name: &str) -> Result<(), StoreError> {
        check_scene_name(name)?;
        if self.name_of(asset)?.is_some_and(|known| known == name) {
            return Ok(());
        }
        let path = self.name_path(asset);
        self.write(&path, name.as_bytes()).map_err(|reason| StoreError::Io { path, reason })
    }

    /// What people call an asset; `None` where nobody has said. A file that holds no name counts for nothing said.
    pub fn name_of(&self, asset: &AssetHash) -> Result<Option<String>, StoreError> {
        let path = self.name_path(asset);
        let mut bytes = Vec::new();
        // One byte over the limit, which no name can have then.
        let most = MAX_NAME_BYTES as u64 + 1;
        match File::open(&path).and_then(|file| file.take(most).read_to_end(&mut bytes)) {
            Ok(_) => Ok(String::from_utf8(bytes).ok().filter(|name| check_scene_name(name).is_ok())),
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(reason) => Err(StoreError::Io { path, reason }),
        }
    }

    /// The bytes of that hash; `None` where they are not here.
    pub fn bytes(&self, asset: &AssetHash) -> Result<Option<Vec<u8>>, StoreError> {
        let bytes = match self.read(asset) {
            Ok(bytes) => bytes,
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(reason) => return Err(StoreError::Io { path: self.path(asset), reason }),
        };
        if AssetHash::of(&bytes) == *asset { Ok(Some(bytes)) } else { Err(StoreError::DamagedAsset(*asset)) }
    }

    /// At most one byte over the limit, which no hash can match then.
    fn read(&self, asset: &AssetHash) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        File::open(self.path(asset))?.take(MAX_ASSET_BYTES + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// First beside its place, so that a file of that name is always whole.
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let mut file = tempfile::Builder::new().prefix(PARTIAL_PREFIX).tempfile_in(&self.folder)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        sync_folder(&self.folder)
    }

    /// Removes what was left of assets whose writing was cut off. Only while nobody else writes assets.
    pub fn remove_leftovers(&self) -> Result<(), StoreError> {
        let removed = fs::read_dir(&self.folder).and_then(|files| {
            for file in files {
                let file = file?;
                if file.file_name().to_string_lossy().starts_with(PARTIAL_PREFIX) {
                    fs::remove_file(file.path())?;
                }
            }
            Ok(())
        });
        removed.map_err(|reason| StoreError::Io { path: self.folder.clone(), reason })
    }

    /// The files of assets and of their names, with their sizes in bytes.
    pub(crate) fn files(&self) -> Result<Vec<(PathBuf, u64)>, StoreError> {
        let listed = fs::read_dir(&self.folder).and_then(|files| {
            let files = files.map(|file| file.and_then(|file| Ok((file.path(), file.metadata()?))));
            files.collect::<io::Result<Vec<_>>>()
        });
        let files = match listed {
            Ok(files) => files,
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(reason) => return Err(StoreError::Io { path: self.folder.clone(), reason }),
        };
        let is_leftover = |path: &Path| {
            path.file_name().is_none_or(|name| name.to_string_lossy().starts_with(PARTIAL_PREFIX))
        };
        let whole = files.into_iter().filter(|(path, metadata)| metadata.is_file() && !is_leftover(path));
        Ok(whole.map(|(path, metadata)| (path, metadata.len())).collect())
    }

    /// Copies a file of other assets, which has its name from what it holds. It is not on the disk before [`Assets::sync`].
    pub(crate) fn copy_in(&self, file: &Path) -> Result<(), StoreError> {
        let path = file.file_name().map_or_else(|| self.folder.clone(), |name| self.folder.join(name));
        let copied = fs::copy(file, &path).and_then(|_| File::open(&path)?.sync_all());
        copied.map_err(|reason| StoreError::Io { path, reason })
    }

    /// Returns when the names of all files here are on the disk.
    pub(crate) fn sync(&self) -> Result<(), StoreError> {
        sync_folder(&self.folder).map_err(|reason| StoreError::Io { path: self.folder.clone(), reason })
    }

    fn path(&self, asset: &AssetHash) -> PathBuf {
        self.folder.join(asset.hex())
    }

    fn name_path(&self, asset: &AssetHash) -> PathBuf {
        self.folder.join(asset.hex() + NAME_SUFFIX)
    }
}

/// Refuses a file where the data folder should be.
pub fn check_folder(data: &Path) -> Result<(), StoreError> {
    if data.is_file() { Err(StoreError::NotAFolder(data.into())) } else { Ok(()) }
}

/// Refuses what cannot be what people call a scene.
pub fn check_scene_name(name: &str) -> Result<(), StoreError> {
    if is_label(name) { Ok(()) } else { Err(StoreError::BadSceneName) }
}

/// Whether people can call something so: not nothing, not too much, nothing that no line of text holds, and nothing that
/// stands for bytes that were no UTF-8.
pub(crate) fn is_label(name: &str) -> bool {
    let is_text = !name.contains(|c: char| c.is_control() || c == char::REPLACEMENT_CHARACTER);
    (1..=MAX_NAME_BYTES).contains(&name.len()) && name.trim() == name && is_text
}

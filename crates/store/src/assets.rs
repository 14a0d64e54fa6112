//! Asset files, each named by the hash of its bytes, with a file for its display name beside it.

use std::fs::{self, DirBuilder, File};
use std::io::{self, Read, Write};
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use document::AssetHash;
use light::MAX_NAME_BYTES;

use crate::StoreError;
use crate::disk::sync_folder;
use crate::limits::MAX_ASSET_BYTES;

pub(crate) const ASSETS_FOLDER: &str = "assets";
/// Suffix of the file that holds the display name of an asset.
const NAME_SUFFIX: &str = ".name";
/// Prefix of a file that is still being written.
const PARTIAL_PREFIX: &str = ".incoming-";

/// The assets of a data folder.
#[derive(Clone, Debug)]
pub struct Assets {
    folder: PathBuf,
}

impl Assets {
    /// Makes the assets of the data folder `data`, which may be missing or hold nothing else.
    pub fn in_folder(data: &Path) -> Self {
        Self { folder: data.join(ASSETS_FOLDER) }
    }

    /// Opens the assets of the data folder `data`. Gives an error if there is no assets folder.
    pub fn open(data: &Path) -> Result<Self, StoreError> {
        check_folder(data)?;
        let assets = Self::in_folder(data);
        if assets.folder.is_dir() { Ok(assets) } else { Err(StoreError::NoAssets(data.into())) }
    }

    pub(crate) fn make_folder(&self) -> Result<(), StoreError> {
        let made = DirBuilder::new().recursive(true).mode(0o700).create(&self.folder);
        made.map_err(|reason| StoreError::Io { path: self.folder.clone(), reason })
    }

    /// Stores the bytes. They are on disk when this returns. Bytes that are already there are not written again.
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

    /// Stores the display name of an asset and replaces an earlier one. The name is on disk when this returns.
    pub fn set_name(&self, asset: &AssetHash, name: &str) -> Result<(), StoreError> {
        check_scene_name(name)?;
        if self.name_of(asset)?.is_some_and(|known| known == name) {
            return Ok(());
        }
        let path = self.name_path(asset);
        self.write(&path, name.as_bytes()).map_err(|reason| StoreError::Io { path, reason })
    }

    /// Reads the display name of an asset. Returns `None` if it has none. A file without a valid name counts as none.
    pub fn name_of(&self, asset: &AssetHash) -> Result<Option<String>, StoreError> {
        let path = self.name_path(asset);
        let mut bytes = Vec::new();
        // One byte over the limit shows that the file holds no valid name.
        let most = MAX_NAME_BYTES as u64 + 1;
        match File::open(&path).and_then(|file| file.take(most).read_to_end(&mut bytes)) {
            Ok(_) => Ok(String::from_utf8(bytes).ok().filter(|name| check_scene_name(name).is_ok())),
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(reason) => Err(StoreError::Io { path, reason }),
        }
    }

    /// Reads the bytes of that hash and checks them. Returns `None` if the file is missing.
    pub fn bytes(&self, asset: &AssetHash) -> Result<Option<Vec<u8>>, StoreError> {
        let bytes = match self.read(asset) {
            Ok(bytes) => bytes,
            Err(reason) if reason.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(reason) => return Err(StoreError::Io { path: self.path(asset), reason }),
        };
        if AssetHash::of(&bytes) == *asset { Ok(Some(bytes)) } else { Err(StoreError::DamagedAsset(*asset)) }
    }

    /// Reads at most one byte over the limit. No hash matches a file of that size.
    fn read(&self, asset: &AssetHash) -> io::Result<Vec<u8>> {
        let mut bytes = Vec::new();
        File::open(self.path(asset))?.take(MAX_ASSET_BYTES + 1).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    /// Writes a temporary file and renames it, so a file of that name is always complete.
    fn write(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        fs::create_dir_all(&self.folder)?;
        let mut file = tempfile::Builder::new().prefix(PARTIAL_PREFIX).tempfile_in(&self.folder)?;
        file.write_all(bytes)?;
        file.as_file().sync_all()?;
        file.persist(path)?;
        sync_folder(&self.folder)
    }

    /// Removes the partial files of interrupted writes. The caller must be the only writer of assets.
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

    /// Lists the complete files of assets and names, with their sizes in bytes.
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
        let is_leftover =
            |path: &Path| path.file_name().is_none_or(|name| name.to_string_lossy().starts_with(PARTIAL_PREFIX));
        let whole = files.into_iter().filter(|(path, metadata)| metadata.is_file() && !is_leftover(path));
        Ok(whole.map(|(path, metadata)| (path, metadata.len())).collect())
    }

    /// Copies a file from another assets folder. Its name follows from its content. The name is on disk only after
    /// [`Assets::sync`].
    pub(crate) fn copy_in(&self, file: &Path) -> Result<(), StoreError> {
        let path = file.file_name().map_or_else(|| self.folder.clone(), |name| self.folder.join(name));
        let copied = fs::copy(file, &path).and_then(|_| File::open(&path)?.sync_all());
        copied.map_err(|reason| StoreError::Io { path, reason })
    }

    /// Waits until the names of all files in the folder are on disk.
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

/// Refuses a data folder that is a file.
pub fn check_folder(data: &Path) -> Result<(), StoreError> {
    if data.is_file() { Err(StoreError::NotAFolder(data.into())) } else { Ok(()) }
}

/// Refuses an invalid display name for a scene.
pub fn check_scene_name(name: &str) -> Result<(), StoreError> {
    if is_label(name) { Ok(()) } else { Err(StoreError::BadSceneName) }
}

/// True if the text is a valid display name: neither empty nor too long, without spaces at its ends, control
/// characters, or replacement characters for bytes that were not UTF-8.
pub(crate) fn is_label(name: &str) -> bool {
    let is_text = !name.contains(|c: char| c.is_control() || c == char::REPLACEMENT_CHARACTER);
    (1..=MAX_NAME_BYTES).contains(&name.len()) && name.trim() == name && is_text
}

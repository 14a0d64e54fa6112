//! A data folder: a database of logs, and a folder of assets.

use std::fs::DirBuilder;
use std::os::unix::fs::DirBuilderExt;
use std::path::{Path, PathBuf};

use crate::StoreError;
use crate::sqlite::{DATABASE, Database};

/// The folder of assets in the data folder.
const ASSETS: &str = "assets";
/// All that the store keeps in the data folder, and for nobody but its owner.
pub const FILES: &[&str] = &[DATABASE, "bendylights.sqlite-wal", "bendylights.sqlite-shm", ASSETS];

/// One connection to a data folder. Several may be open at a time, in this program and others: one writes, the others
/// wait their turn; reading waits for nobody.
#[derive(Debug)]
pub struct Store {
    pub(crate) database: Database,
    pub(crate) assets: PathBuf,
}

impl Store {
    /// Opens the data in `folder`, and makes what is missing.
    pub fn create(folder: &Path) -> Result<Self, StoreError> {
        let assets = folder.join(ASSETS);
        let made = DirBuilder::new().recursive(true).mode(0o700).create(&assets);
        made.map_err(|reason| StoreError::Io { path: assets.clone(), reason })?;
        Ok(Self { database: Database::create(folder)?, assets })
    }

    /// Opens the data in `folder`, which must be there.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        Ok(Self { database: Database::open(folder)?, assets: folder.join(ASSETS) })
    }
}

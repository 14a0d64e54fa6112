//! The data folder: a database of logs and a folder of assets.

use std::path::Path;

use crate::StoreError;
use crate::assets::{ASSETS_FOLDER, Assets, check_folder};
use crate::sqlite::{DATABASE_FILE, Database};

/// All files and folders of the store in the data folder. Only their owner may read them.
pub const FILES: &[&str] = &[DATABASE_FILE, "bendylights.sqlite-wal", "bendylights.sqlite-shm", ASSETS_FOLDER];

/// A connection to a data folder. Several can be open at once, in this program and others. One writes while the other
/// writers wait. Reads never wait.
#[derive(Debug)]
pub struct Store {
    pub(crate) database: Database,
    /// Scenes that the logs load.
    pub assets: Assets,
}

impl Store {
    /// Opens the data in `folder`, and makes the missing files.
    pub fn create(folder: &Path) -> Result<Self, StoreError> {
        check_folder(folder)?;
        let assets = Assets::in_folder(folder);
        assets.make_folder()?;
        Ok(Self { database: Database::create(folder)?, assets })
    }

    /// Opens the data in `folder`. Gives an error if it is missing.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        check_folder(folder)?;
        Ok(Self { database: Database::open(folder)?, assets: Assets::in_folder(folder) })
    }
}

//! A data folder: a database of logs, and a folder of assets.

use std::path::Path;

use crate::StoreError;
use crate::assets::{ASSETS_FOLDER, Assets, check_folder};
use crate::sqlite::{DATABASE_FILE, Database};

/// All that the store keeps in the data folder, and for nobody but its owner.
pub const FILES: &[&str] =
    &[DATABASE_FILE, "bendylights.sqlite-wal", "bendylights.sqlite-shm", ASSETS_FOLDER];

/// One connection to a data folder. Several may be open at a time, in this program and others: one writes, the others
/// wait their turn; reading waits for nobody.
#[derive(Debug)]
pub struct Store {
    pub(crate) database: Database,
    /// The scenes that its logs load.
    pub assets: Assets,
}

impl Store {
    /// Opens the data in `folder`, and makes what is missing.
    pub fn create(folder: &Path) -> Result<Self, StoreError> {
        check_folder(folder)?;
        let assets = Assets::in_folder(folder);
        assets.make_folder()?;
        Ok(Self { database: Database::create(folder)?, assets })
    }

    /// Opens the data in `folder`, which must be there.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        check_folder(folder)?;
        Ok(Self { database: Database::open(folder)?, assets: Assets::in_folder(folder) })
    }
}

//! Opening the database, so that what is committed is on the disk.

use std::fs::{DirBuilder, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use rusqlite::{Connection, TransactionBehavior};

use crate::StoreError;

/// The database's name in the data folder.
pub const DATABASE: &str = "bendylights.sqlite";
/// The folder of assets in the data folder.
const ASSETS: &str = "assets";
/// All that the store keeps in the data folder, and for nobody but its owner.
pub const FILES: &[&str] = &[DATABASE, "bendylights.sqlite-wal", "bendylights.sqlite-shm", ASSETS];
/// The database's `user_version`.
const SCHEMA_VERSION: u32 = 1;
/// How long to wait for another program that is writing.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);

/// One connection to a data folder. Several may be open at a time, in this program and others: one writes, the others
/// wait their turn; reading waits for nobody.
#[derive(Debug)]
pub struct Store {
    pub(crate) connection: Connection,
    pub(crate) assets: PathBuf,
}

impl Store {
    /// Opens the data in `folder`, and makes what is missing.
    pub fn create(folder: &Path) -> Result<Self, StoreError> {
        let assets = folder.join(ASSETS);
        let made = DirBuilder::new().recursive(true).mode(0o700).create(&assets);
        made.map_err(|reason| StoreError::Io { path: assets.clone(), reason })?;
        let database = folder.join(DATABASE);
        // SQLite gives the files beside its database the rights of that, and would let everybody read it.
        let made = File::options().create(true).append(true).mode(0o600).open(&database);
        let synced = made.and_then(|_| sync_folder(folder));
        synced.map_err(|reason| StoreError::Io { path: database.clone(), reason })?;
        Self::connect(database, assets)
    }

    /// Opens the data in `folder`, which must be there.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        let database = folder.join(DATABASE);
        if !database.is_file() {
            return Err(StoreError::NoData(folder.into()));
        }
        Self::connect(database, folder.join(ASSETS))
    }

    fn connect(path: PathBuf, assets: PathBuf) -> Result<Self, StoreError> {
        let mut connection = Connection::open(&path)?;
        connection.busy_timeout(BUSY_TIMEOUT)?;
        let mode: String = connection.query_row("PRAGMA journal_mode = WAL", [], |row| row.get(0))?;
        if mode != "wal" {
            return Err(StoreError::NoWriteAheadLog(path));
        }
        // FULL: a commit returns once its part of the write-ahead log is on the disk.
        connection.execute_batch("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON")?;
        match schema_version(&connection)? {
            0 => make_schema(&mut connection)?,
            SCHEMA_VERSION => {}
            found => return Err(StoreError::Newer { path, found }),
        }
        Ok(Self { connection, assets })
    }
}

fn schema_version(connection: &Connection) -> Result<u32, StoreError> {
    Ok(connection.query_row("PRAGMA user_version", [], |row| row.get(0))?)
}

/// Makes the tables, unless another program has just done so.
fn make_schema(connection: &mut Connection) -> Result<(), StoreError> {
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    if schema_version(&transaction)? == 0 {
        transaction.execute_batch(include_str!("schema.sql"))?;
    }
    Ok(transaction.commit()?)
}

/// Waits until the names in `folder` are on the disk, so that a file just put there is found after a power cut.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

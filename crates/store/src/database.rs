//! Opening the database, so that what is committed is on the disk.

use std::fs::{DirBuilder, File};
use std::io;
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use protocol::{FIRST_PROOF, next_proof};
use rusqlite::{Connection, ErrorCode, Transaction, TransactionBehavior, params};

use crate::StoreError;

/// The database's name in the data folder.
pub const DATABASE: &str = "bendylights.sqlite";
/// The folder of assets in the data folder.
const ASSETS: &str = "assets";
/// All that the store keeps in the data folder, and for nobody but its owner.
pub const FILES: &[&str] = &[DATABASE, "bendylights.sqlite-wal", "bendylights.sqlite-shm", ASSETS];
/// The database's `user_version`.
const SCHEMA_VERSION: u32 = 2;
/// How long to wait for another program that is writing.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);

/// One connection to a data folder. Several may be open at a time, in this program and others: one writes, the others
/// wait their turn; reading waits for nobody.
#[derive(Debug)]
pub struct Store {
    pub(crate) connection: Connection,
    pub(crate) assets: PathBuf,
    write_ahead_log: PathBuf,
    /// The write-ahead log may hold a commit that failed ([`Store::failed_commit`]).
    is_unsettled: bool,
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
            0..SCHEMA_VERSION => upgrade_schema(&mut connection)?,
            SCHEMA_VERSION => {}
            found => return Err(StoreError::Newer { path, found }),
        }
        let write_ahead_log = path.with_extension("sqlite-wal");
        Ok(Self { connection, assets, write_ahead_log, is_unsettled: false })
    }

    /// What a commit that failed comes to.
    ///
    /// Where the disk did not confirm it, its pages may stand whole in the write-ahead log, and whoever opens the
    /// database after a crash would find it committed. So the log is emptied before anybody is told that nothing was
    /// changed. Where that fails too, nobody knows.
    pub(crate) fn failed_commit(&mut self, reason: rusqlite::Error) -> StoreError {
        // A log that did not fit on the disk ends before the page that commits.
        let is_full = reason.sqlite_error_code() == Some(ErrorCode::DiskFull);
        self.is_unsettled = !is_full && self.empty_log().is_err();
        if self.is_unsettled { StoreError::Unknown(reason.to_string()) } else { reason.into() }
    }

    /// A transaction that writes, alone in doing so from its start.
    ///
    /// What an earlier commit may have left in the write-ahead log is gone before: it may be the same operation that
    /// is now sent again, and a refusal would be a lie.
    pub(crate) fn writing(&mut self) -> Result<Transaction<'_>, StoreError> {
        if self.is_unsettled {
            self.empty_log().map_err(|reason| StoreError::Unknown(reason.to_string()))?;
            self.is_unsettled = false;
        }
        Ok(self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?)
    }

    /// Moves what is committed from the write-ahead log into the database, and empties the log, on the disk too.
    fn empty_log(&self) -> Result<(), StoreError> {
        let query = "PRAGMA wal_checkpoint(TRUNCATE)";
        let is_busy: bool = self.connection.query_row(query, [], |row| row.get(0))?;
        let synced = if is_busy {
            Err(io::Error::from(io::ErrorKind::ResourceBusy))
        } else {
            File::open(&self.write_ahead_log).and_then(|log| log.sync_all())
        };
        synced.map_err(|reason| StoreError::Io { path: self.write_ahead_log.clone(), reason })
    }
}

fn schema_version(connection: &Connection) -> Result<u32, StoreError> {
    Ok(connection.query_row("PRAGMA user_version", [], |row| row.get(0))?)
}

/// Makes the tables, or brings those of an earlier version up to this one, unless another program has just done so.
fn upgrade_schema(connection: &mut Connection) -> Result<(), StoreError> {
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    if schema_version(&transaction)? == 0 {
        transaction.execute_batch(include_str!("schema-1.sql"))?;
    }
    if schema_version(&transaction)? == 1 {
        transaction.execute_batch(include_str!("schema-2.sql"))?;
        note_proofs(&transaction)?;
    }
    Ok(transaction.commit()?)
}

/// Notes the proofs of logs that were written before there were any.
fn note_proofs(transaction: &Transaction<'_>) -> Result<(), StoreError> {
    let mut select =
        transaction.prepare("SELECT session, seq, json, hash FROM record ORDER BY session, seq")?;
    let mut rows = select.query([])?;
    let (mut noted, mut proof) = (Vec::new(), String::new());
    while let Some(row) = rows.next()? {
        let (session, seq): (i64, u64) = (row.get("session")?, row.get("seq")?);
        let before = if seq == 1 { FIRST_PROOF } else { &proof };
        proof = next_proof(before, row.get_ref("json")?.as_str().map_err(rusqlite::Error::from)?);
        if row.get_ref("hash")? != rusqlite::types::ValueRef::Null {
            noted.push((session, seq, proof.clone()));
        }
    }
    let mut update = transaction.prepare("UPDATE record SET proof = ? WHERE session = ? AND seq = ?")?;
    for (session, seq, proof) in noted {
        update.execute(params![proof, session, seq])?;
    }
    Ok(())
}

/// Waits until the names in `folder` are on the disk, so that a file just put there is found after a power cut.
pub(crate) fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

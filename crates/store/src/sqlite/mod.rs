//! The SQLite database of logs. All SQL is in this folder.
//!
//! The module stores and returns plain values ([`crate::stored`]) and knows no document. Its interface to the store is
//! [`Database`] and [`Writer`]. A second engine would offer the same.

#[cfg(test)]
mod durability;
mod read;
mod snapshot;
mod write;

use std::fs::File;
use std::io;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use protocol::{FIRST_PROOF, next_proof};
use rusqlite::{Connection, ErrorCode, Transaction, TransactionBehavior, params};

use crate::StoreError;
use crate::disk::sync_folder;
pub use snapshot::DatabaseSnapshot;
pub use write::Writer;

/// Name of the database file in the data folder.
pub const DATABASE_FILE: &str = "bendylights.sqlite";
/// `user_version` of the database.
const SCHEMA_VERSION: u32 = 4;
/// Time to wait while another program writes.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);

/// A connection to a database. Several can be open at once, in this program and others. One writes while the other
/// writers wait. Reads never wait.
#[derive(Debug)]
pub struct Database {
    connection: Connection,
    write_ahead_log: PathBuf,
    /// True if the write-ahead log may hold a failed commit ([`Database::failed_commit`]).
    may_hold_failed_commit: bool,
}

impl Database {
    /// Opens the database in `folder`, and makes the folder's missing files.
    pub fn create(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(DATABASE_FILE);
        // SQLite gives the files beside its database the permissions of the database. Its default would let everybody
        // read them.
        let made = File::options().create(true).append(true).mode(0o600).open(&path);
        let synced = made.and_then(|_| sync_folder(folder));
        synced.map_err(|reason| StoreError::Io { path: path.clone(), reason })?;
        Self::connect(path)
    }

    /// Opens the database in `folder`. Gives an error if it is missing.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(DATABASE_FILE);
        if !path.is_file() {
            return Err(StoreError::NoData(folder.into()));
        }
        Self::connect(path)
    }

    /// Does `work` in one transaction, which is on disk when this returns. On an error other than
    /// [`StoreError::UnknownOutcome`] nothing is written.
    pub fn write<T>(&mut self, work: impl FnOnce(&Writer) -> Result<T, StoreError>) -> Result<T, StoreError> {
        let writer = self.begin()?;
        let done = work(&writer)?;
        let committed = writer.commit();
        committed.map_err(|reason| self.failed_commit(reason))?;
        Ok(done)
    }

    fn connect(path: PathBuf) -> Result<Self, StoreError> {
        let mut connection = Connection::open(&path)?;
        connection.busy_timeout(BUSY_TIMEOUT)?;
        let mode: String = connection.query_row("PRAGMA journal_mode = WAL", [], |row| row.get(0))?;
        if mode != "wal" {
            return Err(StoreError::NoWriteAheadLog(path));
        }
        // FULL: a commit returns once its part of the write-ahead log is on disk. Deleted and replaced data is
        // overwritten, so the file keeps nothing of deleted sessions or earlier checkpoints.
        connection.execute_batch("PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON; PRAGMA secure_delete = ON")?;
        match schema_version(&connection)? {
            0..SCHEMA_VERSION => upgrade_schema(&mut connection)?,
            SCHEMA_VERSION => {}
            found => return Err(StoreError::NewerDatabase { path, found }),
        }
        let write_ahead_log = path.with_extension("sqlite-wal");
        Ok(Self { connection, write_ahead_log, may_hold_failed_commit: false })
    }

    /// Cleans up after a failed commit and returns its error.
    ///
    /// The pages of a commit that the disk did not confirm may still be complete in the write-ahead log. A program that
    /// opens the database after a crash would find it committed. So the log is emptied before the caller learns that
    /// nothing was changed. If that fails too, the outcome is unknown.
    fn failed_commit(&mut self, reason: rusqlite::Error) -> StoreError {
        // A log that did not fit on the disk ends before the page that commits.
        let is_full = reason.sqlite_error_code() == Some(ErrorCode::DiskFull);
        self.may_hold_failed_commit = !is_full && self.truncate_write_ahead_log().is_err();
        if self.may_hold_failed_commit { StoreError::UnknownOutcome(reason.to_string()) } else { reason.into() }
    }

    /// Begins a write transaction. It excludes other writers from its start.
    ///
    /// First it removes the remains of a failed commit from the write-ahead log. The new transaction may repeat the
    /// same operation, and a refusal would be wrong if the failed commit came back.
    fn begin(&mut self) -> Result<Writer<'_>, StoreError> {
        if self.may_hold_failed_commit {
            self.truncate_write_ahead_log().map_err(|reason| StoreError::UnknownOutcome(reason.to_string()))?;
            self.may_hold_failed_commit = false;
        }
        Ok(Writer(self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?))
    }

    /// Empties the write-ahead log, which still holds the deleted data. While somebody reads, such as a long backup,
    /// this does nothing, and a later commit empties the log. No commit waits for it.
    pub fn purge_deleted(&self) -> Result<(), StoreError> {
        self.connection.busy_timeout(Duration::ZERO)?;
        // The deletion itself is already committed.
        let _ = self.truncate_write_ahead_log();
        Ok(self.connection.busy_timeout(BUSY_TIMEOUT)?)
    }

    /// Moves committed pages from the write-ahead log into the database, then empties the log on disk.
    fn truncate_write_ahead_log(&self) -> Result<(), StoreError> {
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

impl From<rusqlite::Error> for StoreError {
    fn from(error: rusqlite::Error) -> Self {
        Self::Database(error.to_string())
    }
}

fn schema_version(connection: &Connection) -> Result<u32, StoreError> {
    Ok(connection.query_row("PRAGMA user_version", [], |row| row.get(0))?)
}

/// Creates the tables, or upgrades those of an earlier version, unless another program has done so in the meantime.
fn upgrade_schema(connection: &mut Connection) -> Result<(), StoreError> {
    let transaction = connection.transaction_with_behavior(TransactionBehavior::Immediate)?;
    if schema_version(&transaction)? == 0 {
        transaction.execute_batch(include_str!("schema-1.sql"))?;
    }
    if schema_version(&transaction)? == 1 {
        transaction.execute_batch(include_str!("schema-2.sql"))?;
        note_proofs(&transaction)?;
    }
    for (before, upgrade) in [(2, include_str!("schema-3.sql")), (3, include_str!("schema-4.sql"))] {
        if schema_version(&transaction)? == before {
            transaction.execute_batch(upgrade)?;
        }
    }
    Ok(transaction.commit()?)
}

/// Adds the proofs to logs that were written before proofs existed.
fn note_proofs(transaction: &Transaction<'_>) -> Result<(), StoreError> {
    let mut select = transaction.prepare("SELECT session, seq, json, hash FROM record ORDER BY session, seq")?;
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

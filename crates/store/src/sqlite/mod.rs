//! The database of logs, in SQLite: all SQL is in this folder.
//!
//! It keeps and gives plain values ([`crate::stored`]) and knows no document. What it has to do for the store is what
//! [`Database`] and [`Writer`] can do; a second engine has to do the same.

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

/// The database's name in the data folder.
pub const DATABASE_FILE: &str = "bendylights.sqlite";
/// The database's `user_version`.
const SCHEMA_VERSION: u32 = 4;
/// How long to wait for another program that is writing.
const BUSY_TIMEOUT: Duration = Duration::from_secs(10);

/// A connection to a database. Several may be open at a time, in this program and others: one writes, the others wait
/// their turn; reading waits for nobody.
#[derive(Debug)]
pub struct Database {
    connection: Connection,
    write_ahead_log: PathBuf,
    /// The write-ahead log may hold a commit that failed ([`Database::failed_commit`]).
    may_hold_failed_commit: bool,
}

impl Database {
    /// Opens the database in `folder`, and makes what is missing.
    pub fn create(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(DATABASE_FILE);
        // SQLite gives the files beside its database the rights of that, and would let everybody read it.
        let made = File::options().create(true).append(true).mode(0o600).open(&path);
        let synced = made.and_then(|_| sync_folder(folder));
        synced.map_err(|reason| StoreError::Io { path: path.clone(), reason })?;
        Self::connect(path)
    }

    /// Opens the database in `folder`, which must be there.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(DATABASE_FILE);
        if !path.is_file() {
            return Err(StoreError::NoData(folder.into()));
        }
        Self::connect(path)
    }

    /// Does `work` in one transaction: all of it is on the disk when this returns. On an error none is, but for
    /// [`StoreError::UnknownOutcome`].
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
        // FULL: a commit returns once its part of the write-ahead log is on the disk. What is deleted or replaced is
        // overwritten, so that nothing of a deleted session is left in the file, earlier checkpoints neither.
        connection.execute_batch(
            "PRAGMA synchronous = FULL; PRAGMA foreign_keys = ON; PRAGMA secure_delete = ON",
        )?;
        match schema_version(&connection)? {
            0..SCHEMA_VERSION => upgrade_schema(&mut connection)?,
            SCHEMA_VERSION => {}
            found => return Err(StoreError::NewerDatabase { path, found }),
        }
        let write_ahead_log = path.with_extension("sqlite-wal");
        Ok(Self { connection, write_ahead_log, may_hold_failed_commit: false })
    }

    /// What a commit that failed comes to.
    ///
    /// Where the disk did not confirm it, its pages may stand whole in the write-ahead log, and whoever opens the
    /// database after a crash would find it committed. So the log is emptied before anybody is told that nothing was
    /// changed. Where that fails too, nobody knows.
    fn failed_commit(&mut self, reason: rusqlite::Error) -> StoreError {
        // A log that did not fit on the disk ends before the page that commits.
        let is_full = reason.sqlite_error_code() == Some(ErrorCode::DiskFull);
        self.may_hold_failed_commit = !is_full && self.truncate_write_ahead_log().is_err();
        if self.may_hold_failed_commit {
            StoreError::UnknownOutcome(reason.to_string())
        } else {
            reason.into()
        }
    }

    /// A transaction that writes, alone in doing so from its start.
    ///
    /// What an earlier commit may have left in the write-ahead log is gone before: it may be the same operation that
    /// is now sent again, and a refusal would be a lie.
    fn begin(&mut self) -> Result<Writer<'_>, StoreError> {
        if self.may_hold_failed_commit {
            self.truncate_write_ahead_log()
                .map_err(|reason| StoreError::UnknownOutcome(reason.to_string()))?;
            self.may_hold_failed_commit = false;
        }
        Ok(Writer(self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?))
    }

    /// Empties the write-ahead log, in which what was deleted stands as it was. Where somebody is reading, as a backup
    /// does for long, later commits do so: none waits for it.
    pub fn purge_deleted(&self) -> Result<(), StoreError> {
        self.connection.busy_timeout(Duration::ZERO)?;
        // What was deleted is so in any case.
        let _ = self.truncate_write_ahead_log();
        Ok(self.connection.busy_timeout(BUSY_TIMEOUT)?)
    }

    /// Moves what is committed from the write-ahead log into the database, and empties the log, on the disk too.
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
    if schema_version(&transaction)? == 2 {
        transaction.execute_batch(include_str!("schema-3.sql"))?;
    }
    if schema_version(&transaction)? == 3 {
        transaction.execute_batch(include_str!("schema-4.sql"))?;
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

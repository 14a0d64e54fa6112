//! A snapshot of the database, copied while others continue to write.

use std::fs::File;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use rusqlite::backup::{Backup, StepResult};
use rusqlite::{Connection, OpenFlags};

use super::{BUSY_TIMEOUT, DATABASE_FILE, SCHEMA_VERSION, schema_version};
use crate::StoreError;

/// Number of pages copied between two reports of progress: about 1 MiB.
const PAGES_PER_STEP: i32 = 256;

/// A read transaction on the database. Later commits are not in it and do not wait for it.
#[derive(Debug)]
pub struct DatabaseSnapshot {
    connection: Connection,
    /// Number of sessions and of records.
    pub counts: [u64; 2],
    /// Size of all pages.
    pub bytes: u64,
}

impl DatabaseSnapshot {
    /// Takes a snapshot of the database in `folder`. The copy keeps the schema version of the original.
    pub fn take(folder: &Path) -> Result<Self, StoreError> {
        let path = folder.join(DATABASE_FILE);
        if !path.is_file() {
            return Err(StoreError::NoData(folder.into()));
        }
        // Read-write access, since even a reader of a database with a write-ahead log takes part in its locks.
        let connection = Connection::open_with_flags(&path, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
        connection.busy_timeout(BUSY_TIMEOUT)?;
        // The transaction begins with its first read and lasts as long as the connection.
        connection.execute_batch("BEGIN")?;
        match schema_version(&connection)? {
            // An interrupted first start has made no tables.
            0 => return Err(StoreError::NoData(folder.into())),
            1..=SCHEMA_VERSION => {}
            found => return Err(StoreError::NewerDatabase { path, found }),
        }
        let number = |query: &str| connection.query_row(query, [], |row| row.get::<_, u64>(0));
        let bytes = number("PRAGMA page_count")? * number("PRAGMA page_size")?;
        let counts = [number("SELECT count(*) FROM session")?, number("SELECT count(*) FROM record")?];
        Ok(Self { connection, counts, bytes })
    }

    /// Writes the snapshot as the database of another folder, which has none. It is on disk when this returns. `copied`
    /// receives the bytes of each step.
    pub fn copy_to(self, folder: &Path, copied: &mut dyn FnMut(u64)) -> Result<(), StoreError> {
        let path = folder.join(DATABASE_FILE);
        let made = File::options().create_new(true).write(true).mode(0o600).open(&path);
        made.map_err(|reason| StoreError::Io { path: path.clone(), reason })?;
        let mut copy = Connection::open(&path)?;
        let backup = Backup::new(&self.connection, &mut copy)?;
        let mut done = 0;
        loop {
            let step = backup.step(PAGES_PER_STEP)?;
            let progress = backup.progress();
            let pages = u64::try_from(progress.pagecount).unwrap_or(0);
            let left = u64::try_from(progress.remaining).unwrap_or(0);
            let by_now = self.bytes / pages.max(1) * (pages - left.min(pages));
            copied(by_now.saturating_sub(done));
            done = done.max(by_now);
            match step {
                StepResult::Done => break,
                StepResult::More => {}
                _ => return Err(StoreError::Database("it is locked".into())),
            }
        }
        drop(backup);
        // A backup must be readable.
        let check: String = copy.query_row("PRAGMA quick_check(1)", [], |row| row.get(0))?;
        if check != "ok" {
            return Err(StoreError::Database(check));
        }
        copy.close().map_err(|(_, reason)| reason)?;
        let synced = File::open(&path).and_then(|file| file.sync_all());
        synced.map_err(|reason| StoreError::Io { path, reason })
    }
}

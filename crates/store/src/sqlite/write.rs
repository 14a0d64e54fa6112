//! Writes to the database, in one transaction.

use std::ops::ControlFlow;

use protocol::{CompactLine, LogPosition, Record};
use rusqlite::{ErrorCode, OptionalExtension, Row, Transaction, params};

use super::read::{find, find_summary, visit_records};
use crate::StoreError;
use crate::limits::{MAX_ALL_REJECTIONS, MAX_REJECTIONS};
use crate::stored::{FoundSession, Rejection, SessionChange, SessionKey, SessionSummary, StoredRecord};

/// Write transaction. [`super::Database::write`] commits it. If it is dropped before, its writes are undone.
pub struct Writer<'a>(pub(super) Transaction<'a>);

impl Writer<'_> {
    pub(super) fn commit(self) -> rusqlite::Result<()> {
        self.0.commit()
    }

    pub fn find(&self, name: &str) -> Result<FoundSession, StoreError> {
        find(&self.0, name)
    }

    pub fn count_sessions(&self) -> Result<u64, StoreError> {
        Ok(self.0.query_row("SELECT count(*) FROM session", [], |row| row.get(0))?)
    }

    pub fn summary(&self, name: &str) -> Result<SessionSummary, StoreError> {
        find_summary(&self.0, name)
    }

    /// Makes a session whose log begins in `format`. Returns its key and its epoch, or `None` if the name is taken.
    pub fn insert_session(
        &self,
        name: &str,
        title: Option<&str>,
        format: u32,
    ) -> Result<Option<(SessionKey, String)>, StoreError> {
        let insert = "
            INSERT INTO session (name, title, format, made_ms)
            VALUES (?, ?, ?, CAST(unixepoch('subsec') * 1000 AS INTEGER))
            ON CONFLICT DO NOTHING RETURNING id, epoch";
        let row = params![name, title, format];
        let made = self.0.query_row(insert, row, |row| Ok((SessionKey(row.get(0)?), row.get(1)?)));
        Ok(made.optional()?)
    }

    /// Changes the title of a session, and archives or restores it. What is `None` stays.
    pub fn change_session(&self, key: SessionKey, change: &SessionChange) -> Result<(), StoreError> {
        let SessionChange { title, archived } = change;
        let update = "UPDATE session SET title = coalesce(?, title), archived = coalesce(?, archived) WHERE id = ?";
        Ok(self.0.execute(update, params![title, archived, key.0]).map(drop)?)
    }

    /// Copies the records, their noted hashes and the checkpoint of `from` to `to`, which has no record. Copies no
    /// proofs.
    pub fn copy_log(&self, from: SessionKey, to: SessionKey) -> Result<(), StoreError> {
        let copies = [
            "INSERT INTO record (session, seq, actor, op_id, json, hash)
             SELECT ?2, seq, actor, op_id, json, hash FROM record WHERE session = ?1 ORDER BY seq",
            "INSERT INTO held_value (session, hash, record, at)
             SELECT ?2, hash, record, at FROM held_value WHERE session = ?1",
            "INSERT INTO checkpoint (session, seq, json, digest)
             SELECT ?2, seq, json, digest FROM checkpoint WHERE session = ?1",
            "UPDATE session SET (changed_ms, changed_by) =
             (SELECT changed_ms, changed_by FROM session WHERE id = ?1) WHERE id = ?2",
        ];
        for copy in copies {
            self.0.execute(copy, params![from.0, to.0])?;
        }
        Ok(())
    }

    /// Calls `visit` with all records of a session, in order.
    pub fn visit_all_records(
        &self,
        key: SessionKey,
        mut visit: impl FnMut(StoredRecord) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let range = 1..=i64::MAX.unsigned_abs();
        visit_records(&self.0, key, range, &mut |record| visit(record).map(ControlFlow::Continue))
    }

    /// Deletes a session with its log and everything that belongs to it.
    pub fn delete_session(&self, key: SessionKey) -> Result<(), StoreError> {
        // Until the commit its records refer to a missing session.
        self.0.execute_batch("PRAGMA defer_foreign_keys = ON")?;
        self.0.execute("DELETE FROM session WHERE id = ?", [key.0])?;
        for table in ["checkpoint", "held_value", "rejection", "record"] {
            self.0.execute(&format!("DELETE FROM {table} WHERE session = ?"), [key.0])?;
        }
        Ok(())
    }

    /// Finds the value with this hash among the long values of a session's log. Returns the position at which the log
    /// contains it in full, or `None` if the log does not contain it.
    pub fn position_of_value(&self, key: SessionKey, hash: &str) -> Result<Option<LogPosition>, StoreError> {
        let select = "SELECT record, at FROM held_value WHERE session = ? AND hash = ?";
        let position = |row: &Row<'_>| Ok(LogPosition { record: row.get("record")?, at: row.get("at")? });
        Ok(self.0.prepare_cached(select)?.query_row(params![key.0, hash], position).optional()?)
    }

    /// Adds the next record to a log as `line`, in which references replace long values that the log already contains.
    /// Refuses a record that does not follow the log, and an operation that the log already has.
    pub fn insert_record(&self, key: SessionKey, record: &Record, line: &CompactLine) -> Result<(), StoreError> {
        let Record { seq, time_ms, actor, op_id, .. } = record;
        let insert = "INSERT INTO record (session, seq, actor, op_id, json) VALUES (?, ?, ?, ?, ?)";
        let row = params![key.0, seq, actor.id, op_id, line.text];
        self.0.prepare_cached(insert)?.execute(row).map_err(|error| match error.sqlite_error_code() {
            Some(ErrorCode::ConstraintViolation) => StoreError::ConcurrentWrite(*seq),
            _ => error.into(),
        })?;
        let change = "UPDATE session SET changed_ms = ?, changed_by = ? WHERE id = ?";
        let time_ms = i64::try_from(*time_ms).unwrap_or(i64::MAX);
        self.0.prepare_cached(change)?.execute(params![time_ms, actor.name, key.0])?;
        let hold = "INSERT INTO held_value (session, hash, record, at) VALUES (?, ?, ?, ?)";
        for (hash, at) in &line.new_values {
            self.0.prepare_cached(hold)?.execute(params![key.0, hash, seq, at])?;
        }
        Ok(())
    }

    /// Stores the hash of the document after record `seq`, and the proof of the log up to this record.
    pub fn note_hash(&self, key: SessionKey, seq: u64, hash: &str, proof: &str) -> Result<(), StoreError> {
        let update = "UPDATE record SET hash = ?, proof = ? WHERE session = ? AND seq = ?";
        Ok(self.0.prepare_cached(update)?.execute(params![hash, proof, key.0, seq]).map(drop)?)
    }

    /// Stores a rejection, and removes the oldest ones over the limits.
    pub fn insert_rejection(&self, key: SessionKey, rejection: &Rejection) -> Result<(), StoreError> {
        let Rejection { actor_id, op_id, problem } = rejection;
        let insert = "
            INSERT INTO rejection (session, actor, op_id, code, message) VALUES (?, ?, ?, ?, ?)
            ON CONFLICT DO NOTHING";
        let row = params![key.0, actor_id, op_id, problem.code.name(), problem.message];
        self.0.prepare_cached(insert)?.execute(row)?;
        let too_many = "
            DELETE FROM rejection WHERE session = ?1 AND actor = ?2 AND id <= (
                SELECT id FROM rejection WHERE session = ?1 AND actor = ?2 ORDER BY id DESC LIMIT 1 OFFSET ?3)";
        self.0.prepare_cached(too_many)?.execute(params![key.0, actor_id, MAX_REJECTIONS])?;
        let too_old = "DELETE FROM rejection WHERE id <= (SELECT max(id) FROM rejection) - ?";
        self.0.prepare_cached(too_old)?.execute([MAX_ALL_REJECTIONS])?;
        Ok(())
    }

    /// Stores a session's checkpoint after record `seq` and replaces an earlier one.
    pub fn replace_checkpoint(&self, key: SessionKey, seq: u64, json: &str, digest: &str) -> Result<(), StoreError> {
        let replace = "INSERT OR REPLACE INTO checkpoint (session, seq, json, digest) VALUES (?, ?, ?, ?)";
        Ok(self.0.execute(replace, params![key.0, seq, json, digest]).map(drop)?)
    }
}

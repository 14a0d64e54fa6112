//! What is written to the database, in one transaction.

use std::ops::ControlFlow;

use protocol::LogPosition;
use rusqlite::{ErrorCode, OptionalExtension, Row, Transaction, params};

use super::read::{find, find_summary, visit_records};
use crate::StoreError;
use crate::limits::{MAX_ALL_REJECTIONS, MAX_REJECTIONS};
use crate::stored::{FoundSession, NewRecord, Rejection, SessionKey, SessionSummary, StoredRecord};

/// A transaction that writes. What it has written stays only if [`super::Database::write`] commits it.
pub struct Writer<'a>(pub(super) Transaction<'a>);

impl Writer<'_> {
    /// Makes all that was written stay.
    pub(super) fn commit(self) -> rusqlite::Result<()> {
        self.0.commit()
    }

    /// The session of that name.
    pub fn find(&self, name: &str) -> Result<FoundSession, StoreError> {
        find(&self.0, name)
    }

    /// How many sessions there are.
    pub fn count_sessions(&self) -> Result<u64, StoreError> {
        Ok(self.0.query_row("SELECT count(*) FROM session", [], |row| row.get(0))?)
    }

    /// What the list says of the session of that name.
    pub fn summary(&self, name: &str) -> Result<SessionSummary, StoreError> {
        find_summary(&self.0, name)
    }

    /// Makes a session whose log begins in `format`; its key and its epoch, or `None` where the name is taken.
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

    /// Says what people call a session.
    pub fn set_title(&self, key: SessionKey, title: &str) -> Result<(), StoreError> {
        self.0.execute("UPDATE session SET title = ? WHERE id = ?", params![title, key.0])?;
        Ok(())
    }

    /// Archives a session, or brings it back.
    pub fn set_archived(&self, key: SessionKey, archived: bool) -> Result<(), StoreError> {
        self.0.execute("UPDATE session SET archived = ? WHERE id = ?", params![archived, key.0])?;
        Ok(())
    }

    /// Gives session `to`, which has no record, the records of `from` with the hashes noted there and no proofs, and
    /// its checkpoint.
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

    /// Gives all records of a session to `visit`, in order.
    pub fn visit_all_records(
        &self,
        key: SessionKey,
        mut visit: impl FnMut(StoredRecord) -> Result<(), StoreError>,
    ) -> Result<(), StoreError> {
        let range = 1..=i64::MAX.unsigned_abs();
        visit_records(&self.0, key, range, &mut |record| visit(record).map(ControlFlow::Continue))
    }

    /// Takes an archived session away, with its log and all that is kept of it.
    pub fn delete_session(&self, key: SessionKey) -> Result<(), StoreError> {
        // Until the commit its records refer to nothing.
        self.0.execute_batch("PRAGMA defer_foreign_keys = ON")?;
        self.0.execute("DELETE FROM session WHERE id = ?", [key.0])?;
        for table in ["checkpoint", "held_value", "rejection", "record"] {
            self.0.execute(&format!("DELETE FROM {table} WHERE session = ?"), [key.0])?;
        }
        Ok(())
    }

    /// Where the log holds the long value of that hash.
    pub fn position_of_value(&self, key: SessionKey, hash: &str) -> Result<Option<LogPosition>, StoreError> {
        let select = "SELECT record, at FROM held_value WHERE session = ? AND hash = ?";
        let mut statement = self.0.prepare_cached(select)?;
        let place = |row: &Row<'_>| Ok(LogPosition { record: row.get("record")?, at: row.get("at")? });
        Ok(statement.query_row(params![key.0, hash], place).optional()?)
    }

    /// Adds the next record to a log. Refuses one that does not follow, and an operation that is in it.
    pub fn insert_record(&self, key: SessionKey, record: &NewRecord) -> Result<(), StoreError> {
        let NewRecord { seq, time_ms, actor_id, actor_name, op_id, line, new_values: first_holds } = record;
        let insert = "INSERT INTO record (session, seq, actor, op_id, json) VALUES (?, ?, ?, ?, ?)";
        let row = params![key.0, seq, actor_id, op_id, line];
        self.0.prepare_cached(insert)?.execute(row).map_err(|error| match error.sqlite_error_code() {
            Some(ErrorCode::ConstraintViolation) => StoreError::ConcurrentWrite(*seq),
            _ => error.into(),
        })?;
        let change = "UPDATE session SET changed_ms = ?, changed_by = ? WHERE id = ?";
        let time_ms = i64::try_from(*time_ms).unwrap_or(i64::MAX);
        self.0.prepare_cached(change)?.execute(params![time_ms, actor_name, key.0])?;
        let hold = "INSERT INTO held_value (session, hash, record, at) VALUES (?, ?, ?, ?)";
        for (hash, at) in *first_holds {
            self.0.prepare_cached(hold)?.execute(params![key.0, hash, seq, at])?;
        }
        Ok(())
    }

    /// Notes the hash of the document after record `seq`, and the proof of the log up to it.
    pub fn note_hash(&self, key: SessionKey, seq: u64, hash: &str, proof: &str) -> Result<(), StoreError> {
        let update = "UPDATE record SET hash = ?, proof = ? WHERE session = ? AND seq = ?";
        self.0.prepare_cached(update)?.execute(params![hash, proof, key.0, seq])?;
        Ok(())
    }

    /// Keeps a rejection, and lets go of that actor's oldest.
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

    /// Keeps a session's checkpoint after record `seq`, in place of an earlier one.
    pub fn replace_checkpoint(
        &self,
        key: SessionKey,
        seq: u64,
        json: &str,
        digest: &str,
    ) -> Result<(), StoreError> {
        let replace = "INSERT OR REPLACE INTO checkpoint (session, seq, json, digest) VALUES (?, ?, ?, ?)";
        self.0.execute(replace, params![key.0, seq, json, digest])?;
        Ok(())
    }
}

//! What is written to the database, in one transaction.

use protocol::{FORMAT, Place};
use rusqlite::{ErrorCode, OptionalExtension, Row, Transaction, params};

use super::read::find;
use crate::StoreError;
use crate::limits::{MAX_ALL_REJECTIONS, MAX_REJECTIONS};
use crate::stored::{Found, NewRecord, Rejection, SessionKey};

/// A transaction that writes. What it has written stays only if [`super::Database::write`] commits it.
pub struct Writer<'a>(pub(super) Transaction<'a>);

impl Writer<'_> {
    /// Makes all that was written stay.
    pub(super) fn commit(self) -> rusqlite::Result<()> {
        self.0.commit()
    }

    /// The session of that name.
    pub fn find(&self, name: &str) -> Result<Found, StoreError> {
        find(&self.0, name)
    }

    /// How many sessions there are.
    pub fn count_sessions(&self) -> Result<u64, StoreError> {
        Ok(self.0.query_row("SELECT count(*) FROM session", [], |row| row.get(0))?)
    }

    /// Makes a session; its key and its epoch, or `None` where the name is taken.
    pub fn insert_session(&self, name: &str) -> Result<Option<(SessionKey, String)>, StoreError> {
        let insert = "
            INSERT INTO session (name, format) VALUES (?, ?) ON CONFLICT DO NOTHING RETURNING id, epoch";
        let made =
            self.0.query_row(insert, params![name, FORMAT], |row| Ok((SessionKey(row.get(0)?), row.get(1)?)));
        Ok(made.optional()?)
    }

    /// Where the log holds the long value of that hash.
    pub fn place_of(&self, key: SessionKey, hash: &str) -> Result<Option<Place>, StoreError> {
        let select = "SELECT record, at FROM held_value WHERE session = ? AND hash = ?";
        let mut statement = self.0.prepare_cached(select)?;
        let place = |row: &Row<'_>| Ok(Place { record: row.get("record")?, at: row.get("at")? });
        Ok(statement.query_row(params![key.0, hash], place).optional()?)
    }

    /// Adds the next record to a log. Refuses one that does not follow, and an operation that is in it.
    pub fn insert_record(&self, key: SessionKey, record: &NewRecord) -> Result<(), StoreError> {
        let NewRecord { seq, actor_id, op_id, line, first_holds } = record;
        let insert = "INSERT INTO record (session, seq, actor, op_id, json) VALUES (?, ?, ?, ?, ?)";
        let row = params![key.0, seq, actor_id, op_id, line];
        self.0.prepare_cached(insert)?.execute(row).map_err(|error| match error.sqlite_error_code() {
            Some(ErrorCode::ConstraintViolation) => StoreError::OutOfStep(*seq),
            _ => error.into(),
        })?;
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

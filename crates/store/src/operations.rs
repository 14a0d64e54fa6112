//! What became of operations, for those that come again (SPEC, REC-4).

use edit::Action;
use protocol::ErrorCode;
use rusqlite::types::Type;
use rusqlite::{Connection, OptionalExtension, Row, params};

use crate::sessions::{Found, find};
use crate::{Store, StoreError};

/// Rejections that are kept of one actor in a session.
pub const MAX_REJECTIONS: u64 = 1_000;
/// Rejections that are kept of all actors in all sessions.
const MAX_ALL_REJECTIONS: i64 = 1_000_000;

/// An operation that was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejection {
    /// Who asked.
    pub actor_id: String,
    /// The sender's name for the operation.
    pub op_id: String,
    /// Why, for programs.
    pub code: ErrorCode,
    /// Why, for people.
    pub message: String,
}

/// What became of an operation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is in the log.
    Committed {
        /// Its record.
        seq: u64,
        /// Whether somebody else had changed the same light in between.
        rebased: bool,
        /// What an undo or redo left as it was.
        skipped: Vec<String>,
    },
    /// It was refused.
    Rejected {
        /// Why, for programs.
        code: ErrorCode,
        /// Why, for people.
        message: String,
    },
}

impl Store {
    /// What became of an actor's operation in a session; `None` where it never came, or was refused too long ago.
    pub fn outcome(&self, session: &str, actor_id: &str, op_id: &str) -> Result<Option<Outcome>, StoreError> {
        let Found { key, .. } = find(&self.connection, session)?;
        let select = "SELECT seq FROM record WHERE session = ? AND actor = ? AND op_id = ?";
        let operation = params![key, actor_id, op_id];
        let seq: Option<u64> =
            self.connection.prepare_cached(select)?.query_row(operation, |row| row.get(0)).optional()?;
        if let Some(seq) = seq {
            let line = self.line(key, seq)?.ok_or(StoreError::OutOfStep(seq))?;
            let (rebased, skipped) = match protocol::Record::answer_in(&line) {
                Some(answer) => answer,
                None => self.answer_in_full(session, seq)?,
            };
            return Ok(Some(Outcome::Committed { seq, rebased, skipped }));
        }
        let select = "SELECT code, message FROM rejection WHERE session = ? AND actor = ? AND op_id = ?";
        let mut statement = self.connection.prepare_cached(select)?;
        let rejected = statement.query_row(operation, |row| {
            Ok(Outcome::Rejected { code: code(row)?, message: row.get("message")? })
        });
        Ok(rejected.optional()?)
    }

    /// Whether record `seq` was rebased, and what it skipped.
    fn answer_in_full(&self, session: &str, seq: u64) -> Result<(bool, Vec<String>), StoreError> {
        let record = self.records(session, seq, 1)?.pop().ok_or(StoreError::OutOfStep(seq))?;
        let record =
            edit::Record::try_from(record).map_err(|reason| StoreError::Meaningless { seq, reason })?;
        Ok((record.action.rebased(), Action::skipped(&record.action).to_vec()))
    }
}

/// The code of a kept rejection.
fn code(row: &Row<'_>) -> rusqlite::Result<ErrorCode> {
    let name = row.get_ref("code")?.as_str()?;
    ErrorCode::named(name).ok_or_else(|| {
        let unknown = format!("`{name}` is no code that this version knows").into();
        rusqlite::Error::FromSqlConversionFailure(0, Type::Text, unknown)
    })
}

/// Keeps a rejection, and lets go of that actor's oldest.
pub(crate) fn insert_rejection(
    connection: &Connection,
    key: i64,
    rejection: &Rejection,
) -> Result<(), StoreError> {
    let Rejection { actor_id, op_id, code, message } = rejection;
    let insert = "INSERT INTO rejection (session, actor, op_id, code, message) VALUES (?, ?, ?, ?, ?) ON CONFLICT DO NOTHING";
    connection.prepare_cached(insert)?.execute(params![key, actor_id, op_id, code.name(), message])?;
    let too_many = "
        DELETE FROM rejection WHERE session = ?1 AND actor = ?2 AND id <= (
            SELECT id FROM rejection WHERE session = ?1 AND actor = ?2 ORDER BY id DESC LIMIT 1 OFFSET ?3)";
    connection.prepare_cached(too_many)?.execute(params![key, actor_id, MAX_REJECTIONS])?;
    let too_old = "DELETE FROM rejection WHERE id <= (SELECT max(id) FROM rejection) - ?";
    connection.prepare_cached(too_old)?.execute([MAX_ALL_REJECTIONS])?;
    Ok(())
}

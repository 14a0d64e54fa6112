//! Reads from the database.

use std::ops::{ControlFlow, RangeInclusive};

use document::Document;
use protocol::{ErrorCode, Problem};
use rusqlite::{CachedStatement, Connection, OptionalExtension, Row, named_params, params};

use super::Database;
use crate::StoreError;
use crate::stored::{FoundSession, LastChange, SessionKey, SessionRow, SessionSummary, StoredCheckpoint, StoredRecord};

/// Query of a session with its latest record.
const SESSION: &str = "
    SELECT name, epoch, format, coalesce(seq, 0) AS seq, coalesce(hash, :empty) AS hash, proof, id
    FROM session
    LEFT JOIN record ON session = id AND seq = (SELECT max(seq) FROM record WHERE session = id)
    WHERE name = :name";

/// Query of the list of sessions. It reads no lines of records, because an index contains the latest number.
const SUMMARIES: &str = "
    SELECT name, coalesce(title, name) AS title, epoch, archived, made_ms, changed_ms, changed_by,
        coalesce((SELECT max(seq) FROM record WHERE session = id), 0) AS seq
    FROM session";

impl Database {
    /// Lists all sessions by name.
    pub fn summaries(&self) -> Result<Vec<SessionSummary>, StoreError> {
        let mut statement = summaries(&self.connection, "ORDER BY name")?;
        let rows = statement.query_map([], summary)?;
        Ok(rows.collect::<Result<_, _>>()?)
    }

    pub fn summary(&self, name: &str) -> Result<SessionSummary, StoreError> {
        find_summary(&self.connection, name)
    }

    pub fn find(&self, name: &str) -> Result<FoundSession, StoreError> {
        find(&self.connection, name)
    }

    /// Calls `visit` with the records in `range`, in order, until it breaks.
    pub fn visit_records(
        &self,
        key: SessionKey,
        range: RangeInclusive<u64>,
        mut visit: impl FnMut(StoredRecord) -> Result<ControlFlow<()>, StoreError>,
    ) -> Result<(), StoreError> {
        visit_records(&self.connection, key, range, &mut visit)
    }

    /// Reads the line of record `seq`, with its references unresolved.
    pub fn line(&self, key: SessionKey, seq: u64) -> Result<Option<String>, StoreError> {
        let select = "SELECT json FROM record WHERE session = ? AND seq = ?";
        Ok(self.connection.prepare_cached(select)?.query_row(params![key.0, seq], |row| row.get(0)).optional()?)
    }

    /// Finds the record of an actor's operation.
    pub fn record_of(&self, key: SessionKey, actor_id: &str, op_id: &str) -> Result<Option<u64>, StoreError> {
        let select = "SELECT seq FROM record WHERE session = ? AND actor = ? AND op_id = ?";
        let operation = params![key.0, actor_id, op_id];
        Ok(self.connection.prepare_cached(select)?.query_row(operation, |row| row.get(0)).optional()?)
    }

    /// Finds the reason for which an actor's operation was refused. Returns `None` if no rejection is kept.
    pub fn rejection_of(&self, key: SessionKey, actor_id: &str, op_id: &str) -> Result<Option<Problem>, StoreError> {
        let select = "SELECT code, message FROM rejection WHERE session = ? AND actor = ? AND op_id = ?";
        let mut statement = self.connection.prepare_cached(select)?;
        let kept = statement
            .query_row(params![key.0, actor_id, op_id], |row| Ok((row.get::<_, String>("code")?, row.get("message")?)));
        let Some((code, message)) = kept.optional()? else { return Ok(None) };
        let code = ErrorCode::named(&code).ok_or(StoreError::UnknownCode(code))?;
        Ok(Some(Problem { code, message }))
    }

    pub fn checkpoint(&self, key: SessionKey) -> Result<Option<StoredCheckpoint>, StoreError> {
        let select = "
            SELECT checkpoint.json, digest, hash, proof, record.json AS line
            FROM checkpoint JOIN record USING (session, seq) WHERE session = ?";
        let mut statement = self.connection.prepare_cached(select)?;
        let row = statement.query_row([key.0], |row| {
            let (json, digest, line) = (row.get("json")?, row.get("digest")?, row.get("line")?);
            Ok(StoredCheckpoint { json, digest, line, hash: row.get("hash")?, proof: row.get("proof")? })
        });
        Ok(row.optional()?)
    }
}

/// Calls `visit` with the records in `range`, in order, until it breaks.
pub(super) fn visit_records(
    connection: &Connection,
    key: SessionKey,
    range: RangeInclusive<u64>,
    visit: &mut dyn FnMut(StoredRecord) -> Result<ControlFlow<()>, StoreError>,
) -> Result<(), StoreError> {
    let select = "
        SELECT seq, json, hash, proof FROM record WHERE session = ? AND seq BETWEEN ? AND ? ORDER BY seq";
    let mut statement = connection.prepare_cached(select)?;
    let mut rows = statement.query(params![key.0, range.start(), range.end()])?;
    while let Some(row) = rows.next()? {
        let (seq, line) = (row.get("seq")?, row.get("json")?);
        let record = StoredRecord { seq, line, hash: row.get("hash")?, proof: row.get("proof")? };
        if visit(record)?.is_break() {
            break;
        }
    }
    Ok(())
}

pub(super) fn find(connection: &Connection, name: &str) -> Result<FoundSession, StoreError> {
    let mut statement = connection.prepare_cached(SESSION)?;
    let empty = Document::default().hash().to_string();
    let params = named_params! {":name": name, ":empty": empty};
    let found = statement
        .query_row(params, |row| Ok(FoundSession { key: SessionKey(row.get("id")?), row: session_row(row)? }))
        .optional()?;
    found.ok_or_else(|| StoreError::NoSession(name.into()))
}

fn session_row(row: &Row<'_>) -> rusqlite::Result<SessionRow> {
    let (name, format, noted): (_, _, Option<String>) = (row.get("name")?, row.get("format")?, row.get("proof")?);
    let mut row = SessionRow {
        name,
        epoch: row.get("epoch")?,
        format,
        seq: row.get("seq")?,
        hash: row.get("hash")?,
        proof: String::new(),
    };
    row.proof = noted.unwrap_or_else(|| row.first_proof());
    Ok(row)
}

pub(super) fn find_summary(connection: &Connection, name: &str) -> Result<SessionSummary, StoreError> {
    let found = summaries(connection, "WHERE name = ?")?.query_row([name], summary).optional()?;
    found.ok_or_else(|| StoreError::NoSession(name.into()))
}

fn summaries<'a>(connection: &'a Connection, which: &str) -> rusqlite::Result<CachedStatement<'a>> {
    connection.prepare_cached(&format!("{SUMMARIES} {which}"))
}

fn summary(row: &Row<'_>) -> rusqlite::Result<SessionSummary> {
    let changed_ms: Option<u64> = row.get("changed_ms")?;
    let actor_name: Option<String> = row.get("changed_by")?;
    Ok(SessionSummary {
        name: row.get("name")?,
        title: row.get("title")?,
        epoch: row.get("epoch")?,
        seq: row.get("seq")?,
        is_archived: row.get("archived")?,
        made_ms: row.get("made_ms")?,
        changed: changed_ms.zip(actor_name).map(|(time_ms, actor_name)| LastChange { time_ms, actor_name }),
    })
}

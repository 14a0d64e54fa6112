//! The sessions of a data folder.

use document::Document;
use protocol::FIRST_PROOF;
use rusqlite::{Connection, OptionalExtension, Row, named_params};

use crate::{Store, StoreError};

/// Characters that a session's name has at most.
pub const MAX_NAME_CHARS: usize = 64;
/// Sessions that a data folder holds at most.
pub const MAX_SESSIONS: u64 = 10_000;

/// A session and how far its log goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionRow {
    /// Its name.
    pub name: String,
    /// Names this history: 128 random bits in hexadecimal, another one for each session that is made or imported.
    pub epoch: String,
    /// The latest record, 0 before the first.
    pub seq: u64,
    /// The document's hash after it, 64 hexadecimal digits.
    pub hash: String,
    /// The log's proof up to it ([`protocol::next_proof`]), 64 hexadecimal digits.
    pub proof: String,
}

/// A session with its key in the database.
pub(crate) struct Found {
    pub key: i64,
    pub row: SessionRow,
}

/// Each session with its latest record. `:name` is a session's name, or null for all of them.
const SELECT: &str = "
    SELECT name, epoch, coalesce(seq, 0) AS seq, coalesce(hash, :empty) AS hash,
        coalesce(proof, :first) AS proof, id
    FROM session
    LEFT JOIN record ON session = id AND seq = (SELECT max(seq) FROM record WHERE session = id)
    WHERE :name IS NULL OR name = :name
    ORDER BY name";

impl Store {
    /// Makes a session with an empty document, and gives its epoch.
    pub fn create_session(&mut self, name: &str) -> Result<String, StoreError> {
        let transaction = self.writing()?;
        let (_, epoch) = insert_session(&transaction, name)?;
        transaction.commit()?;
        Ok(epoch)
    }

    /// All sessions, in the order of names.
    pub fn sessions(&self) -> Result<Vec<SessionRow>, StoreError> {
        let mut statement = self.connection.prepare_cached(SELECT)?;
        let empty = Document::default().hash().to_string();
        let none = named_params! {":name": None::<&str>, ":empty": empty, ":first": FIRST_PROOF};
        let rows = statement.query_map(none, session_row)?;
        Ok(rows.collect::<Result<_, _>>()?)
    }

    /// The session of that name.
    pub fn session(&self, name: &str) -> Result<SessionRow, StoreError> {
        find(&self.connection, name).map(|found| found.row)
    }
}

/// The session of that name.
pub(crate) fn find(connection: &Connection, name: &str) -> Result<Found, StoreError> {
    let mut statement = connection.prepare_cached(SELECT)?;
    let empty = Document::default().hash().to_string();
    let params = named_params! {":name": name, ":empty": empty, ":first": FIRST_PROOF};
    let found = statement
        .query_row(params, |row| Ok(Found { key: row.get("id")?, row: session_row(row)? }))
        .optional()?;
    found.ok_or_else(|| StoreError::NoSession(name.into()))
}

fn session_row(row: &Row<'_>) -> rusqlite::Result<SessionRow> {
    Ok(SessionRow {
        name: row.get("name")?,
        epoch: row.get("epoch")?,
        seq: row.get("seq")?,
        hash: row.get("hash")?,
        proof: row.get("proof")?,
    })
}

/// A new session's key in the database and its epoch.
pub(crate) fn insert_session(connection: &Connection, name: &str) -> Result<(i64, String), StoreError> {
    if !is_name(name) {
        return Err(StoreError::BadName(name.into()));
    }
    let count: u64 = connection.query_row("SELECT count(*) FROM session", [], |row| row.get(0))?;
    if count >= MAX_SESSIONS {
        return Err(StoreError::TooManySessions);
    }
    let insert = "INSERT INTO session (name) VALUES (?) ON CONFLICT DO NOTHING RETURNING id, epoch";
    let made = connection.query_row(insert, [name], |row| Ok((row.get(0)?, row.get(1)?))).optional()?;
    made.ok_or_else(|| StoreError::Exists(name.into()))
}

fn is_name(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let starts = |c: char| c.is_ascii_alphanumeric();
    name.len() <= MAX_NAME_CHARS && name.starts_with(starts) && name.chars().all(allowed)
}

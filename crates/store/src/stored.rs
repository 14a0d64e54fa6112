//! What is kept, in plain values: what the store's logic and its database say to each other.

use protocol::{LogHeader, LogReader, Problem};

/// A session and how far its log goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionRow {
    /// Its name.
    pub name: String,
    /// Names this history: 128 random bits in hexadecimal, another one for each session that is made or imported.
    pub epoch: String,
    /// The [`protocol::FORMAT`] in which it began.
    pub format: u32,
    /// The latest record, 0 before the first.
    pub seq: u64,
    /// The document's hash after it, 64 hexadecimal digits, as the version made it that wrote the record.
    pub hash: String,
    /// The log's proof up to it ([`protocol::next_proof`]), 64 hexadecimal digits.
    pub proof: String,
}

impl SessionRow {
    /// The first line of its log.
    pub(crate) fn header(&self) -> LogHeader {
        LogHeader { format: self.format, session: self.name.clone() }
    }

    /// The proof before its first record.
    pub(crate) fn first_proof(&self) -> String {
        let header = self.header();
        header.first_proof(&header.to_json())
    }

    /// Reads its log from the first record.
    pub(crate) fn reader(&self) -> LogReader {
        LogReader::new(&self.header())
    }
}

/// What a list says of a session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionSummary {
    /// What addresses, commands and its log call it; it stays.
    pub name: String,
    /// What people call it, by default its name.
    pub title: String,
    /// Names its history, as in [`SessionRow`].
    pub epoch: String,
    /// The latest record, 0 before the first.
    pub seq: u64,
    /// Nobody works on it, and it can be deleted.
    pub is_archived: bool,
    /// When it was made in this folder, in milliseconds since 1970.
    pub made_ms: Option<u64>,
    /// `None` before the first record.
    pub changed: Option<LastChange>,
}

/// Of a session's latest record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LastChange {
    /// In milliseconds since 1970.
    pub time_ms: u64,
    /// Who made it.
    pub actor_name: String,
}

/// The database's own name for a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionKey(pub i64);

/// A session with its key.
pub struct FoundSession {
    pub key: SessionKey,
    pub row: SessionRow,
}

/// A record as it is kept.
pub struct StoredRecord {
    pub seq: u64,
    /// Its line in a log file.
    pub line: String,
    /// Of the document after it, where that was noted.
    pub hash: Option<String>,
    /// Of all lines up to it, where that was noted.
    pub proof: Option<String>,
}

/// A record to keep, the next of its log.
pub struct NewRecord<'a> {
    pub seq: u64,
    pub time_ms: u64,
    pub actor_id: &'a str,
    pub actor_name: &'a str,
    pub op_id: &'a str,
    /// Its line in a log file.
    pub line: &'a str,
    /// The long values that it is the first to hold: the hash of each, and the byte of the line where it begins.
    pub new_values: &'a [(String, usize)],
}

/// A checkpoint as it is kept, with what the log says of its record.
pub struct StoredCheckpoint {
    pub json: String,
    /// SHA-256 of `json`, in hexadecimal.
    pub digest: String,
    /// Its record's line in a log file.
    pub line: String,
    /// Of the document after its record.
    pub hash: Option<String>,
    /// Of the log up to its record.
    pub proof: Option<String>,
}

/// An operation that was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejection {
    /// Who asked.
    pub actor_id: String,
    /// The sender's name for the operation.
    pub op_id: String,
    /// Why.
    pub problem: Problem,
}

//! Plain values that the store's logic and its database exchange.

use protocol::{LogHeader, LogReader, Problem};

/// A session and the end of its log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionRow {
    pub name: String,
    /// Identifies this history: 128 random bits in hexadecimal, new for each session that is made or imported.
    pub epoch: String,
    /// The [`protocol::FORMAT`] of its first record.
    pub format: u32,
    /// Number of the latest record. 0 before the first.
    pub seq: u64,
    /// Hash of the document after the latest record, as 64 hexadecimal digits, in the format of the version that wrote
    /// the record.
    pub hash: String,
    /// Proof of the log up to the latest record ([`protocol::next_proof`]), as 64 hexadecimal digits.
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

    /// Makes a reader of its log, from the first record on.
    pub(crate) fn reader(&self) -> LogReader {
        LogReader::new(&self.header())
    }
}

/// A row of the list of sessions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionSummary {
    /// Permanent name in addresses, commands and the log.
    pub name: String,
    /// Display name. The default is the name.
    pub title: String,
    /// Identifies its history, as in [`SessionRow`].
    pub epoch: String,
    /// Number of the latest record. 0 before the first.
    pub seq: u64,
    /// True if nobody works on the session. Then it can be deleted.
    pub is_archived: bool,
    /// Creation time in this folder, in milliseconds since 1970.
    pub made_ms: Option<u64>,
    /// `None` before the first record.
    pub changed: Option<LastChange>,
}

/// Time and actor of a session's latest record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LastChange {
    /// Milliseconds since 1970.
    pub time_ms: u64,
    pub actor_name: String,
}

/// Key of a session in the database.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SessionKey(pub i64);

pub struct FoundSession {
    pub key: SessionKey,
    pub row: SessionRow,
}

/// A record of the database.
pub struct StoredRecord {
    pub seq: u64,
    /// Line in a log file.
    pub line: String,
    /// Hash of the document after the record, if one was noted.
    pub hash: Option<String>,
    /// Proof of all lines up to the record, if one was noted.
    pub proof: Option<String>,
}

/// The next record of a log.
pub struct NewRecord<'a> {
    pub seq: u64,
    pub time_ms: u64,
    pub actor_id: &'a str,
    pub actor_name: &'a str,
    pub op_id: &'a str,
    /// Line in a log file.
    pub line: &'a str,
    /// Long values that the log does not hold yet: the hash of each, and the byte at which it begins in the line.
    pub new_values: &'a [(String, usize)],
}

/// A checkpoint of the database, with the log's data of its record.
pub struct StoredCheckpoint {
    pub json: String,
    /// SHA-256 of `json` in hexadecimal.
    pub digest: String,
    /// Line of its record in a log file.
    pub line: String,
    /// Hash of the document after its record.
    pub hash: Option<String>,
    /// Proof of the log up to its record.
    pub proof: Option<String>,
}

/// A refused operation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejection {
    pub actor_id: String,
    /// The sender's id of the operation.
    pub op_id: String,
    pub problem: Problem,
}

//! Plain values that the store's logic and its database exchange.

use protocol::{LogHeader, LogReader, Problem};

/// Session, and the state of its log after the latest record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionRow {
    pub name: String,
    /// Id of the session's history: 128 random bits in hexadecimal, new for each session that is made or imported.
    pub epoch: String,
    /// Format ([`protocol::FORMAT`]) of the log's first record.
    pub format: u32,
    /// Number of the latest record. 0 before the first.
    pub seq: u64,
    /// Hash of the document after the latest record, as 64 hexadecimal digits, in the format of the version that wrote
    /// the record.
    pub hash: String,
    /// Proof of the log up to the latest record ([`protocol::next_proof`]), as 64 hexadecimal digits.
    pub proof: String,
}

/// Changes of a session's title and archived state. A property that is `None` stays.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SessionChange {
    pub title: Option<String>,
    /// True archives the session, false restores it.
    pub archived: Option<bool>,
}

impl SessionRow {
    /// Returns the first line of the session's log.
    pub(crate) fn header(&self) -> LogHeader {
        LogHeader { format: self.format, session: self.name.clone() }
    }

    /// Returns the proof before the first record of the session's log.
    pub(crate) fn first_proof(&self) -> String {
        let header = self.header();
        header.first_proof(&header.to_json())
    }

    /// Makes a reader of the session's log, starting with the first record.
    pub(crate) fn reader(&self) -> LogReader {
        LogReader::new(&self.header())
    }
}

/// Entry in the list of sessions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionSummary {
    /// Permanent name in addresses, commands and the log.
    pub name: String,
    /// Display name. By default it is the name.
    pub title: String,
    /// Id of the session's history, as in [`SessionRow`].
    pub epoch: String,
    /// Number of the latest record. 0 before the first.
    pub seq: u64,
    /// True if the session is archived, so that people no longer work on it. Only such a session can be deleted.
    pub is_archived: bool,
    /// Time at which the session was created in this data folder, in milliseconds since 1970.
    pub made_ms: Option<u64>,
    /// Time and actor of the latest record. `None` before the first record.
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
    /// Line of the record in a log file.
    pub line: String,
    /// Hash of the document after the record. Stored for the last record of each batch only.
    pub hash: Option<String>,
    /// Proof of all lines up to this record. Stored for the last record of each batch only.
    pub proof: Option<String>,
}

/// Checkpoint in the database, with the data that the log has of the checkpoint's record.
pub struct StoredCheckpoint {
    pub json: String,
    /// SHA-256 of `json` in hexadecimal.
    pub digest: String,
    /// Line in a log file of the record after which the checkpoint was made.
    pub line: String,
    /// Hash of the document after that record.
    pub hash: Option<String>,
    /// Proof of the log up to that record.
    pub proof: Option<String>,
}

/// A refused operation.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rejection {
    pub actor_id: String,
    /// Id that the sender gave the operation.
    pub op_id: String,
    pub problem: Problem,
}

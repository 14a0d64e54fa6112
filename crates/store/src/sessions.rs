//! Sessions of a data folder: their names and the ends of their logs.

use document::FIRST_FORMAT_OF_HASH;
use protocol::{FORMAT, Record};

use crate::assets::is_label;
use crate::limits::{MAX_NAME_CHARS, MAX_SESSIONS};
use crate::sqlite::Writer;
use crate::stored::{SessionKey, SessionRow};
use crate::{Store, StoreError};

impl Store {
    /// Makes a session with an empty document and returns its epoch.
    pub fn create_session(&mut self, name: &str) -> Result<String, StoreError> {
        self.database.write(|writer| Ok(insert_session(writer, name, None, FORMAT)?.1))
    }

    /// Returns the hash of a session's document in this version's format. It is the one in the session's row, unless an
    /// earlier version wrote that. Then the log is read.
    pub fn document_hash(&self, row: &SessionRow) -> Result<String, StoreError> {
        let key = self.database.find(&row.name)?.key;
        let last = self.database.line(key, row.seq)?;
        let unreadable = |reason| StoreError::DamagedRecord { seq: row.seq, reason };
        match last.map(|line| Record::format_of(&line)).transpose().map_err(unreadable)? {
            Some(format) if format < FIRST_FORMAT_OF_HASH => {
                Ok(self.open_session(&row.name)?.session.document().hash().to_string())
            }
            _ => Ok(row.hash.clone()),
        }
    }

    /// Finds the session of that name.
    pub fn session(&self, name: &str) -> Result<SessionRow, StoreError> {
        Ok(self.database.find(name)?.row)
    }
}

/// Makes a session and returns its key and its epoch.
pub(crate) fn insert_session(
    writer: &Writer,
    name: &str,
    title: Option<&str>,
    format: u32,
) -> Result<(SessionKey, String), StoreError> {
    check_name(name)?;
    title.map_or(Ok(()), check_title)?;
    if writer.count_sessions()? >= MAX_SESSIONS {
        return Err(StoreError::TooManySessions);
    }
    writer.insert_session(name, title, format)?.ok_or_else(|| StoreError::Exists(name.into()))
}

pub(crate) fn check_name(name: &str) -> Result<(), StoreError> {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let starts = |c: char| c.is_ascii_alphanumeric();
    let is_name = name.len() <= MAX_NAME_CHARS && name.starts_with(starts) && name.chars().all(allowed);
    if is_name { Ok(()) } else { Err(StoreError::BadName(name.into())) }
}

pub(crate) fn check_title(title: &str) -> Result<(), StoreError> {
    if is_label(title) { Ok(()) } else { Err(StoreError::BadTitle) }
}

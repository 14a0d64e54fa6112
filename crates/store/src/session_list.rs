//! The list of sessions, and what is done with whole ones: described, duplicated, deleted.

use protocol::next_proof;

use crate::sessions::{check_title, insert_session};
use crate::stored::{FoundSession, SessionSummary, StoredRecord};
use crate::{Store, StoreError};

/// What is to be another about a session; what is `None` stays.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SessionChange {
    /// What people call it.
    pub title: Option<String>,
    /// Archived, or brought back.
    pub archived: Option<bool>,
}

impl Store {
    /// All sessions, in the order of names. No log is read for it.
    pub fn sessions(&self) -> Result<Vec<SessionSummary>, StoreError> {
        self.database.summaries()
    }

    /// What the list says of the session of that name.
    pub fn summary(&self, name: &str) -> Result<SessionSummary, StoreError> {
        self.database.summary(name)
    }

    /// Changes what the list says of a session. Neither its log nor its name knows of it.
    pub fn change_session(
        &mut self,
        name: &str,
        change: &SessionChange,
    ) -> Result<SessionSummary, StoreError> {
        change.title.as_deref().map_or(Ok(()), check_title)?;
        self.database.write(|writer| {
            let key = writer.find(name)?.key;
            if let Some(title) = &change.title {
                writer.set_title(key, title)?;
            }
            if let Some(archived) = change.archived {
                writer.set_archived(key, archived)?;
            }
            writer.summary(name)
        })
    }

    /// Makes a session `copy` with all of the log of `name`, line for line, and its checkpoint; all of it or, on an error,
    /// nothing. Its proofs are its own, since they cover its name; so those of `name` are held to first, and lines that
    /// were changed get no others.
    pub fn duplicate_session(
        &mut self,
        name: &str,
        copy: &str,
        title: Option<&str>,
    ) -> Result<SessionSummary, StoreError> {
        self.database.write(|writer| {
            let FoundSession { key: original, row } = writer.find(name)?;
            let (key, _) = insert_session(writer, copy, title, row.format)?;
            let (mut of_original, mut of_copy) = (row.first_proof(), writer.find(copy)?.row.proof);
            writer.copy_log(original, key)?;
            writer.visit_all_records(original, |StoredRecord { seq, line, hash, proof }| {
                (of_original, of_copy) = (next_proof(&of_original, &line), next_proof(&of_copy, &line));
                if proof.is_some_and(|noted| noted != of_original) {
                    return Err(StoreError::ProofMismatch { seq });
                }
                hash.map_or(Ok(()), |hash| writer.note_hash(key, seq, &hash, &of_copy))
            })?;
            writer.summary(copy)
        })
    }

    /// Takes an archived session away, with its log and its checkpoint: nothing of it is left on the disk, but for what a
    /// backup that is being made still reads. The scenes that it loads stay: other logs may load them too.
    pub fn delete_session(&mut self, name: &str) -> Result<(), StoreError> {
        self.database.write(|writer| {
            if !writer.summary(name)?.is_archived {
                return Err(StoreError::NotArchived(name.into()));
            }
            writer.delete_session(writer.find(name)?.key)
        })?;
        self.database.purge_deleted()
    }
}

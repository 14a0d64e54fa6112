//! The list of sessions, and operations on whole sessions: describe, duplicate, delete.

use protocol::next_proof;

use crate::sessions::{check_title, insert_session};
use crate::stored::{FoundSession, SessionChange, SessionSummary, StoredRecord};
use crate::{Store, StoreError};

impl Store {
    /// Lists all sessions by name. Reads no log.
    pub fn sessions(&self) -> Result<Vec<SessionSummary>, StoreError> {
        self.database.summaries()
    }

    /// Returns the list's row of the session of that name.
    pub fn summary(&self, name: &str) -> Result<SessionSummary, StoreError> {
        self.database.summary(name)
    }

    /// Changes the title or the archived state of a session. Its log and its name stay.
    pub fn change_session(&mut self, name: &str, change: &SessionChange) -> Result<SessionSummary, StoreError> {
        change.title.as_deref().map_or(Ok(()), check_title)?;
        self.database.write(|writer| {
            writer.change_session(writer.find(name)?.key, change)?;
            writer.summary(name)
        })
    }

    /// Makes a session `copy` with the whole log of `name`, line for line, and its checkpoint. It succeeds completely
    /// or, on an error, changes nothing. Proofs cover the session's name, so the copy has its own. The proofs of `name`
    /// are checked first, so changed lines do not get new proofs.
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

    /// Deletes an archived session with its log and its checkpoint. Nothing of it stays on disk, except for the pages
    /// that a running backup still reads. The scenes stay, since other logs may load them.
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

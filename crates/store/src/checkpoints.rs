//! Checkpoints: the state of a session after one of its records. Opening replays only the records after it.

use document::AssetHash;
use edit::Session;
use protocol::{LogReader, Record, SessionCheckpoint};

use crate::records::RecordTail;
use crate::stored::{FoundSession, SessionKey, SessionRow, StoredCheckpoint};
use crate::{Store, StoreError};

/// Session that was read from the database, with the cost of reading it.
#[derive(Clone, Debug)]
pub struct OpenedSession {
    pub row: SessionRow,
    /// The session after its last record.
    pub session: Session,
    /// Number and size of the records that were replayed.
    pub tail: RecordTail,
    /// Size in bytes of the session's checkpoint. 0 if it has no usable one.
    pub checkpoint_bytes: u64,
    /// True if the checkpoint was damaged or contradicted the log, so that the whole log was replayed.
    pub checkpoint_failed: bool,
}

impl Store {
    /// Opens the session after its last record. It starts from the checkpoint, which the log's hash of that record
    /// proves, and replays the records after it, which are proven as in [`Store::replay`].
    pub fn open_session(&self, session: &str) -> Result<OpenedSession, StoreError> {
        let FoundSession { key, row } = self.database.find(session)?;
        let checkpoint = self.checkpoint(key);
        let checkpoint_failed = matches!(checkpoint, Ok(CheckpointState::Failed) | Err(_));
        let (mut session, mut reader, checkpoint_bytes) = match checkpoint {
            Ok(CheckpointState::Loaded { session, proof, bytes }) => {
                (*session, LogReader::going_on_from(&proof), bytes)
            }
            _ => (Session::default(), row.reader(), 0),
        };
        let tail = self.replay_following(key, &mut session, &mut reader, row.seq)?;
        Ok(OpenedSession { row, session, tail, checkpoint_bytes, checkpoint_failed })
    }

    /// Stores a checkpoint of the session, replaces an earlier one, and returns its size in bytes. Its record must be
    /// in the log as the last one of a batch.
    pub fn keep_checkpoint(
        &mut self,
        session: &str,
        checkpoint: &SessionCheckpoint,
    ) -> Result<u64, StoreError> {
        let json = checkpoint.to_json();
        let digest = digest(&json);
        self.database.write(|writer| {
            let key = writer.find(session)?.key;
            writer.replace_checkpoint(key, checkpoint.seq, &json, &digest)
        })?;
        Ok(json.len() as u64)
    }

    fn checkpoint(&self, key: SessionKey) -> Result<CheckpointState, StoreError> {
        let Some(stored) = self.database.checkpoint(key)? else { return Ok(CheckpointState::None) };
        let StoredCheckpoint { json, digest: expected, line, hash, proof } = stored;
        if digest(&json) != expected {
            return Ok(CheckpointState::Failed);
        }
        let Ok(checkpoint) = SessionCheckpoint::parse(&json) else { return Ok(CheckpointState::Failed) };
        let Ok(session) = checkpoint.into_domain() else { return Ok(CheckpointState::Failed) };
        let Ok(format) = Record::format_of(&line) else { return Ok(CheckpointState::Failed) };
        match proof {
            Some(proof) if hash == Some(session.document().hash_of_format(format).to_string()) => {
                Ok(CheckpointState::Loaded { session: Box::new(session), proof, bytes: json.len() as u64 })
            }
            _ => Ok(CheckpointState::Failed),
        }
    }
}

enum CheckpointState {
    None,
    /// The checkpoint is damaged, or the log does not prove it.
    Failed,
    /// Session after the checkpoint's record, proof of the log up to that record, and size of the checkpoint.
    Loaded {
        session: Box<Session>,
        proof: String,
        bytes: u64,
    },
}

fn digest(json: &str) -> String {
    AssetHash::of(json.as_bytes()).hex()
}

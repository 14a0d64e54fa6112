//! Checkpoints: a session as it was after one of its records, so that opening it replays only what came since.

use document::AssetHash;
use edit::Session;
use protocol::{LogReader, Record, SessionCheckpoint};

use crate::records::RecordTail;
use crate::stored::{FoundSession, SessionKey, SessionRow, StoredCheckpoint};
use crate::{Store, StoreError};

/// A session that was opened.
#[derive(Clone, Debug)]
pub struct OpenedSession {
    /// As it stands in the list of sessions.
    pub row: SessionRow,
    /// After its last record.
    pub session: Session,
    /// What had to be replayed.
    pub tail: RecordTail,
    /// Bytes of its checkpoint; 0 where it has none that is of use.
    pub checkpoint_bytes: u64,
    /// The checkpoint was of no use: it is not what the log says, or damaged. All of the log was replayed.
    pub checkpoint_failed: bool,
}

impl Store {
    /// The session after its last record: from its checkpoint, which is proven by the hash that the log has for that
    /// record, and the records that follow, which are proven as in [`Store::replay`].
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

    /// Keeps the session as its checkpoint, in place of an earlier one; gives its bytes. The record that it stands after
    /// must be in the log, the last of its batch.
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

/// What is found of a checkpoint.
enum CheckpointState {
    None,
    /// It cannot be used.
    Failed,
    /// The session after its record, the log's proof there, and the checkpoint's own bytes.
    Loaded {
        session: Box<Session>,
        proof: String,
        bytes: u64,
    },
}

fn digest(json: &str) -> String {
    AssetHash::of(json.as_bytes()).hex()
}

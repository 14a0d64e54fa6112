//! Checkpoints: the state of a session after one of its records. Opening replays only the records after it.

use document::AssetHash;
use edit::Session;
use protocol::{LogReader, Record, SessionCheckpoint, parse_body};

use crate::records::RecordTail;
use crate::stored::{FoundSession, SessionRow, StoredCheckpoint};
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
        let stored = self.database.checkpoint(key);
        let has_checkpoint = !matches!(stored, Ok(None));
        let loaded = stored.ok().flatten().and_then(LoadedCheckpoint::proven_by_log);
        let checkpoint_failed = has_checkpoint && loaded.is_none();
        let (mut session, mut reader, checkpoint_bytes) = match loaded {
            Some(LoadedCheckpoint { session, proof, bytes }) => (session, LogReader::going_on_from(&proof), bytes),
            None => (Session::default(), row.reader(), 0),
        };
        let tail = self.replay_following(key, &mut session, &mut reader, row.seq)?;
        Ok(OpenedSession { row, session, tail, checkpoint_bytes, checkpoint_failed })
    }

    /// Stores a checkpoint of the session, replaces an earlier one, and returns its size in bytes. Its record must be
    /// in the log as the last one of a batch.
    pub fn keep_checkpoint(&mut self, session: &str, checkpoint: &SessionCheckpoint) -> Result<u64, StoreError> {
        let json = checkpoint.to_json();
        let digest = digest(&json);
        self.database.write(|writer| {
            let key = writer.find(session)?.key;
            writer.replace_checkpoint(key, checkpoint.seq, &json, &digest)
        })?;
        Ok(json.len() as u64)
    }
}

/// Checkpoint of a session.
struct LoadedCheckpoint {
    /// The session after the checkpoint's record.
    session: Session,
    /// Proof of the log up to that record.
    proof: String,
    /// Size of the checkpoint.
    bytes: u64,
}

impl LoadedCheckpoint {
    /// Loads a checkpoint. Returns `None` if it is damaged, or if the log does not prove it.
    fn proven_by_log(stored: StoredCheckpoint) -> Option<Self> {
        let StoredCheckpoint { json, digest: expected, line, hash, proof } = stored;
        let checkpoint: SessionCheckpoint = parse_body(&json).ok().filter(|_| digest(&json) == expected)?;
        let session = checkpoint.into_domain().ok()?;
        let format = Record::format_of(&line).ok()?;
        let is_proven = hash? == session.document().hash_of_format(format).to_string();
        Some(Self { session, proof: proof.filter(|_| is_proven)?, bytes: json.len() as u64 })
    }
}

fn digest(json: &str) -> String {
    AssetHash::of(json.as_bytes()).hex()
}

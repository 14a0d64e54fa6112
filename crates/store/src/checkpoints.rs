//! Checkpoints: a session as it was after one of its records, so that opening it replays only what came since.

use document::{AssetHash, FindScene};
use edit::Session;
use protocol::{LogReader, SessionCheckpoint};
use rusqlite::{OptionalExtension, params};

use crate::sessions::{Found, find};
use crate::{SessionRow, Store, StoreError};

/// Records that follow a checkpoint, and the bytes of their JSON in full: what replaying them costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tail {
    /// How many.
    pub records: u64,
    /// Of JSON.
    pub bytes: u64,
}

impl std::ops::AddAssign for Tail {
    fn add_assign(&mut self, more: Self) {
        self.records += more.records;
        self.bytes += more.bytes;
    }
}

/// A session that was opened.
#[derive(Clone, Debug)]
pub struct Opened {
    /// As it stands in the list of sessions.
    pub row: SessionRow,
    /// After its last record.
    pub session: Session,
    /// What had to be replayed.
    pub tail: Tail,
    /// The checkpoint was of no use: it is not what the log says, or damaged. All of the log was replayed.
    pub checkpoint_failed: bool,
}

impl Store {
    /// The session after its last record: from its checkpoint, which is proven by the hash that the log has for that
    /// record, and the records that follow, which are proven as in [`Store::replay`].
    pub fn open_session(&self, session: &str, find_scene: FindScene) -> Result<Opened, StoreError> {
        let Found { key, row } = find(&self.connection, session)?;
        let checkpoint = self.checkpoint(key, find_scene);
        let checkpoint_failed = matches!(checkpoint, Ok(Checkpointed::Failed) | Err(_));
        let (mut session, mut reader) = match checkpoint {
            Ok(Checkpointed::At(session, proof)) => (*session, LogReader::going_on_from(&proof)),
            _ => (Session::default(), LogReader::default()),
        };
        let tail = self.go_on(key, &mut session, &mut reader, row.seq, find_scene)?;
        Ok(Opened { row, session, tail, checkpoint_failed })
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
        let transaction = self.writing()?;
        let Found { key, .. } = find(&transaction, session)?;
        let replace = "INSERT OR REPLACE INTO checkpoint (session, seq, json, digest) VALUES (?, ?, ?, ?)";
        transaction.execute(replace, params![key, checkpoint.seq, &json, digest])?;
        transaction.commit()?;
        Ok(json.len() as u64)
    }

    fn checkpoint(&self, key: i64, find_scene: FindScene) -> Result<Checkpointed, StoreError> {
        let select = "
            SELECT checkpoint.json, digest, hash, proof
            FROM checkpoint JOIN record USING (session, seq) WHERE session = ?";
        let mut statement = self.connection.prepare_cached(select)?;
        let row = statement.query_row([key], |row| {
            let text = |column| row.get::<_, Option<String>>(column);
            Ok((
                row.get::<_, String>("json")?,
                row.get::<_, String>("digest")?,
                text("hash")?,
                text("proof")?,
            ))
        });
        let Some((json, expected, hash, proof)) = row.optional()? else { return Ok(Checkpointed::None) };
        if digest(&json) != expected {
            return Ok(Checkpointed::Failed);
        }
        let Ok(checkpoint) = SessionCheckpoint::parse(&json) else { return Ok(Checkpointed::Failed) };
        let Ok(session) = checkpoint.into_domain(find_scene) else { return Ok(Checkpointed::Failed) };
        match proof {
            Some(proof) if hash == Some(session.document().hash().to_string()) => {
                Ok(Checkpointed::At(Box::new(session), proof))
            }
            _ => Ok(Checkpointed::Failed),
        }
    }
}

/// What is found of a checkpoint.
enum Checkpointed {
    None,
    /// It cannot be used.
    Failed,
    /// The session after its record, and the log's proof there.
    At(Box<Session>, String),
}

fn digest(json: &str) -> String {
    AssetHash::of(json.as_bytes()).hex()
}

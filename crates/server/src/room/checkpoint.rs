//! Checkpoints of an open session: the decision to write one, and its storage.

use std::sync::Arc;

use protocol::SessionCheckpoint;
use store::RecordTail;
use tokio::task::spawn_blocking;

use super::Room;
use crate::ServerError;
use crate::limits::{CHECKPOINT_AFTER_BYTES, CHECKPOINT_AFTER_RECORDS};

/// True if a session whose checkpoint has `last_bytes` needs a new one after the records of `tail`.
///
/// A checkpoint names everybody who has edited, so it grows with their number. All checkpoints together never take more
/// bytes than the records: each is about as long as the one before, and as many bytes of records lie between two.
fn is_due(tail: RecordTail, last_bytes: u64) -> bool {
    let has_many = tail.records >= CHECKPOINT_AFTER_RECORDS && tail.bytes >= last_bytes;
    has_many || tail.bytes >= CHECKPOINT_AFTER_BYTES.max(4 * last_bytes)
}

impl Room {
    /// Stores a checkpoint once replaying the records since the last one would make opening slow. A failure here only
    /// makes the next opening slower.
    pub(super) async fn keep_checkpoint(&mut self) {
        if !is_due(self.tail, self.checkpoint_bytes) {
            return;
        }
        self.tail = RecordTail::default();
        let (session, name) = (self.session.clone(), Arc::clone(&self.name));
        let stored = match spawn_blocking(move || SessionCheckpoint::from(&session)).await {
            Ok(checkpoint) => {
                self.services.storage.run_exclusive(move |store| store.keep_checkpoint(&name, &checkpoint)).await
            }
            Err(_) => Err(ServerError::Internal),
        };
        match stored {
            Ok(bytes) => self.checkpoint_bytes = bytes,
            Err(error) => tracing::warn!("session {} has no new checkpoint: {error}", self.name),
        }
    }
}

#[cfg(test)]
mod tests {
    use document::Command;
    use edit::{Actor, EditRequest, EditSources, Session};
    use serde_json::json;

    use super::*;

    const EDITS: u64 = 10_000;

    /// Returns the bytes of checkpoints per byte of records after `EDITS` edits. `actor` returns the number of the
    /// actor that makes each edit.
    fn written(actor: impl Fn(u64) -> u64, is_due: impl Fn(RecordTail, u64) -> bool) -> f64 {
        let (mut session, mut tail, mut last_bytes) = (Session::default(), RecordTail::default(), 0);
        let (mut of_records, mut of_checkpoints) = (0, 0);
        for n in 0..EDITS {
            let command = match n {
                0 => json!({"type": "addLight", "light": {"type": "spot"}}),
                n => json!({"type": "setLight", "light": 1, "parameter": {"coneAngle": 10 + n % 50}}),
            };
            let command: protocol::Command = serde_json::from_value(command).unwrap();
            let command = Command::try_from(command).unwrap();
            let actor = Actor { id: format!("{:0>64}", actor(n)), name: "Ada".into() };
            let request = EditRequest::Edit { base_seq: None, command };
            let record = session.execute_request(request, &actor, &n.to_string(), 0, EditSources::default()).unwrap();
            let bytes = protocol::Record::from(&record).to_json().len() as u64;
            of_records += bytes;
            tail += RecordTail { records: 1, bytes };
            if is_due(tail, last_bytes) {
                last_bytes = SessionCheckpoint::from(&session).to_json().len() as u64;
                of_checkpoints += last_bytes;
                tail = RecordTail::default();
            }
        }
        of_checkpoints as f64 / of_records as f64
    }

    #[test]
    fn checkpoints_take_no_more_than_records_whoever_edits() {
        let after_a_count = |tail: RecordTail, _| tail.records >= CHECKPOINT_AFTER_RECORDS;
        let (one, all) = (written(|_| 0, is_due), written(|n| n, is_due));
        assert!(one > 0.0 && all > 0.0, "both have checkpoints: {one} and {all}");
        assert!(one < 0.5 && all <= 1.0, "{one} with one actor, {all} with another for each edit");
        let planted = written(|n| n, after_a_count);
        assert!(planted > 1.5, "{planted}: checkpoints after a count of records alone are caught");
    }
}

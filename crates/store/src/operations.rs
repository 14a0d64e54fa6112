//! Outcomes of operations, for clients that repeat one (SPEC, REC-4).

use protocol::{Committed, Outcome};

use crate::{Store, StoreError};

impl Store {
    /// Returns the outcome of an actor's operation in a session. Returns `None` if the operation never arrived, or if
    /// its rejection is no longer kept.
    pub fn outcome(&self, session: &str, actor_id: &str, op_id: &str) -> Result<Option<Outcome>, StoreError> {
        let key = self.database.find(session)?.key;
        let Some(seq) = self.database.record_of(key, actor_id, op_id)? else {
            return Ok(self.database.rejection_of(key, actor_id, op_id)?.map(Outcome::Rejected));
        };
        let line = self.database.line(key, seq)?.ok_or(StoreError::ConcurrentWrite(seq))?;
        let committed = match Committed::in_line(&line) {
            Some(committed) => committed,
            None => self.committed_outcome(session, seq)?,
        };
        Ok(Some(Outcome::Committed(committed)))
    }

    /// Returns the outcome of record `seq` as its sender received it.
    fn committed_outcome(&self, session: &str, seq: u64) -> Result<Committed, StoreError> {
        let record = self.records(session, seq, 1)?.pop().ok_or(StoreError::ConcurrentWrite(seq))?;
        let record = edit::Record::try_from(record).map_err(|reason| StoreError::InvalidRecord { seq, reason })?;
        Ok(Committed::from(&record))
    }
}

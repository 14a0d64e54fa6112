//! The records of a log: appended together, read one by one.

use edit::Session;
use protocol::{LogLine, Record};
use rusqlite::{ErrorCode, Row, Transaction, TransactionBehavior, params};
use scene::{DocumentHash, FindScene};

use crate::sessions::find;
use crate::{SessionRow, Store, StoreError};

/// Bytes of one record in JSON. One that replaces a document at its limits (256 lights of 258 control points) by
/// another such takes 28 MiB.
pub const MAX_RECORD_BYTES: usize = 32 << 20;

/// Bytes that [`Store::records`] gives at once, but for a single record that has more.
pub const MAX_PAGE_BYTES: usize = 64 << 20;

/// Records of one session that are committed together.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// The session's name.
    pub session: &'a str,
    /// The records, the next of its log in order. None is no error.
    pub records: &'a [edit::Record],
    /// Of the document after the last of them; replay checks it.
    pub hash: DocumentHash,
}

/// Records of session `?1` from `?2` to `?3`.
pub(crate) const RECORDS: &str =
    "SELECT seq, json, hash FROM record WHERE session = ? AND seq BETWEEN ? AND ? ORDER BY seq";

/// A record as it is stored.
pub(crate) struct Stored {
    pub record: Record,
    /// Of the document after it, where that was noted.
    pub hash: Option<String>,
    /// Length of its JSON.
    pub bytes: usize,
}

impl Store {
    /// Writes all batches down in one transaction. They are on the disk when this returns; on an error none is.
    pub fn append(&mut self, batches: &[Batch<'_>]) -> Result<(), StoreError> {
        let transaction = self.writing()?;
        for batch in batches {
            let (key, _) = find(&transaction, batch.session)?;
            let hash = batch.hash.to_string();
            for (index, record) in batch.records.iter().enumerate() {
                let is_last = index + 1 == batch.records.len();
                insert_record(&transaction, key, Box::new(record.into()), is_last.then_some(&hash))?;
            }
        }
        Ok(transaction.commit()?)
    }

    /// The records from `from` on, at most `limit` and [`MAX_PAGE_BYTES`]; none past the end.
    pub fn records(&self, session: &str, from: u64, limit: usize) -> Result<Vec<Record>, StoreError> {
        let (key, SessionRow { seq: last, .. }) = find(&self.connection, session)?;
        let mut statement = self.connection.prepare_cached(RECORDS)?;
        let mut bytes = 0;
        let mut page = Vec::new();
        for stored in statement.query_and_then(params![key, from.min(last + 1), last], stored)?.take(limit) {
            let Stored { record, bytes: more, .. } = stored?;
            bytes += more;
            if bytes > MAX_PAGE_BYTES && !page.is_empty() {
                break;
            }
            page.push(record);
        }
        Ok(page)
    }

    /// The session as it is after record `to`, or after its last. The hash of each batch is checked on the way.
    pub fn replay(
        &self,
        session: &str,
        to: Option<u64>,
        find_scene: FindScene,
    ) -> Result<Session, StoreError> {
        let (key, SessionRow { seq: last, .. }) = find(&self.connection, session)?;
        let to = to.unwrap_or(last);
        if to > last {
            return Err(StoreError::NoRecord { asked: to, last });
        }
        let mut session = Session::default();
        let mut statement = self.connection.prepare_cached(RECORDS)?;
        for stored in statement.query_and_then(params![key, 1, to], stored)? {
            let Stored { record, hash, .. } = stored?;
            take_in(&mut session, record, find_scene)?;
            if hash.is_some_and(|hash| hash != session.document().hash().to_string()) {
                return Err(StoreError::Differs { seq: session.seq() });
            }
        }
        Ok(session)
    }

    /// A transaction that writes, alone in doing so from its start.
    pub(crate) fn writing(&mut self) -> Result<Transaction<'_>, StoreError> {
        Ok(self.connection.transaction_with_behavior(TransactionBehavior::Immediate)?)
    }
}

/// Makes the session go on by a record from outside.
pub(crate) fn take_in(
    session: &mut Session,
    record: Record,
    find_scene: FindScene,
) -> Result<(), StoreError> {
    if session.seq() as usize >= edit::MAX_RECORDS {
        return Err(StoreError::TooManyRecords);
    }
    let seq = record.seq;
    let record = record.try_into().map_err(|reason| StoreError::Meaningless { seq, reason })?;
    Ok(session.replay(&record, find_scene)?)
}

pub(crate) fn stored(row: &Row<'_>) -> Result<Stored, StoreError> {
    let seq = row.get("seq")?;
    let json = row.get_ref("json")?.as_str().map_err(rusqlite::Error::from)?;
    let record = Record::parse(json).map_err(|reason| StoreError::DamagedRecord { seq, reason })?;
    Ok(Stored { record, hash: row.get("hash")?, bytes: json.len() })
}

/// Writes a record of session `key` down, with the hash of the document after it where that is to be noted.
pub(crate) fn insert_record(
    transaction: &Transaction<'_>,
    key: i64,
    record: Box<Record>,
    hash: Option<&String>,
) -> Result<(), StoreError> {
    let (seq, actor, op_id) = (record.seq, record.actor.id.clone(), record.op_id.clone());
    let json = LogLine::Record(record).to_json();
    if json.len() > MAX_RECORD_BYTES {
        return Err(StoreError::RecordTooLarge);
    }
    let insert = "INSERT INTO record (session, seq, actor, op_id, json, hash) VALUES (?, ?, ?, ?, ?, ?)";
    let done = transaction.prepare_cached(insert)?.execute(params![key, seq, actor, op_id, json, hash]);
    match done {
        Ok(_) => Ok(()),
        Err(error) if error.sqlite_error_code() == Some(ErrorCode::ConstraintViolation) => {
            Err(StoreError::OutOfStep(seq))
        }
        Err(error) => Err(error.into()),
    }
}

/// Notes the hash of the document after record `seq`.
pub(crate) fn note_hash(
    transaction: &Transaction<'_>,
    key: i64,
    seq: u64,
    hash: &str,
) -> Result<(), StoreError> {
    let update = "UPDATE record SET hash = ? WHERE session = ? AND seq = ?";
    transaction.prepare_cached(update)?.execute(params![hash, key, seq])?;
    Ok(())
}

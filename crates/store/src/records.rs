//! Records of a log: appended in batches, read one by one.

use std::ops::ControlFlow;

use document::DocumentHash;
use edit::Session;
use protocol::{FORMAT, LogReader, ReadError, Record, compact, next_proof};

use crate::limits::{MAX_HELD_BYTES, MAX_PAGE_BYTES};
use crate::sessions::insert_session;
use crate::sqlite::Writer;
use crate::stored::{FoundSession, Rejection, SessionKey, StoredRecord};
use crate::{MAX_RECORD_BYTES, Store, StoreError};

/// Number and size of records: of those after a checkpoint, or of those by which a log has grown. They determine the
/// time of replaying these records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RecordTail {
    pub records: u64,
    /// Size in bytes of the records' JSON, with every value in full.
    pub bytes: u64,
}

impl std::ops::AddAssign for RecordTail {
    fn add_assign(&mut self, more: Self) {
        self.records += more.records;
        self.bytes += more.bytes;
    }
}

/// Records and rejections of one session that are committed together.
#[derive(Clone, Copy, Debug)]
pub struct CommitBatch<'a> {
    /// Name of the session.
    pub session: &'a str,
    /// The next records of its log, in order. May be empty.
    pub records: &'a [edit::Record],
    /// Operations refused since the last batch.
    pub rejections: &'a [Rejection],
    /// Hash of the document after the last record. Replay checks it.
    pub hash: DocumentHash,
}

impl Store {
    /// Writes all batches in one transaction. They are on disk when this returns. On an error other than
    /// [`StoreError::UnknownOutcome`] nothing is written. Returns the growth of each log.
    pub fn append(&mut self, batches: &[CommitBatch<'_>]) -> Result<Vec<RecordTail>, StoreError> {
        self.database.write(|writer| {
            let insert = |batch: &CommitBatch| insert_batch(writer, &writer.find(batch.session)?, batch);
            batches.iter().map(insert).collect()
        })
    }

    /// Makes a session with the name `first.session`, that title and the first batch, completely or, on an error, not
    /// at all. Returns its epoch.
    pub fn begin_session(&mut self, first: &CommitBatch<'_>, title: Option<&str>) -> Result<String, StoreError> {
        self.database.write(|writer| {
            let (_, epoch) = insert_session(writer, first.session, title, FORMAT)?;
            insert_batch(writer, &writer.find(first.session)?, first)?;
            Ok(epoch)
        })
    }

    /// Returns complete records from `from` on, at most `limit` and at most [`MAX_PAGE_BYTES`] of JSON, except for a
    /// single larger record. Returns none past the end.
    pub fn records(&self, session: &str, from: u64, limit: usize) -> Result<Vec<Record>, StoreError> {
        self.page(session, from, limit, MAX_PAGE_BYTES)
    }

    /// Returns complete records from `from` on, at most `limit` and at most `max_bytes` of JSON, except for a single
    /// larger record. Returns none past the end.
    pub fn page(&self, session: &str, from: u64, limit: usize, max_bytes: usize) -> Result<Vec<Record>, StoreError> {
        let FoundSession { key, row } = self.database.find(session)?;
        let (mut reader, mut bytes, mut page) = (row.reader(), 0, Vec::new());
        if limit == 0 {
            return Ok(page);
        }
        self.database.visit_records(key, from.min(row.seq + 1)..=row.seq, |stored| {
            let (record, more) = self.read_record(&mut reader, key, &stored)?;
            bytes += more;
            if bytes > max_bytes && !page.is_empty() {
                return Ok(ControlFlow::Break(()));
            }
            page.push(record);
            Ok(if page.len() < limit { ControlFlow::Continue(()) } else { ControlFlow::Break(()) })
        })?;
        Ok(page)
    }

    /// Replays the log alone up to record `to`, or to its end, and returns the session. Checks the hash and the proof
    /// of each batch.
    pub fn replay(&self, session: &str, to: Option<u64>) -> Result<Session, StoreError> {
        let FoundSession { key, row } = self.database.find(session)?;
        let to = to.unwrap_or(row.seq);
        if to > row.seq {
            return Err(StoreError::NoRecord { requested: to, last: row.seq });
        }
        let mut session = Session::default();
        self.replay_following(key, &mut session, &mut row.reader(), to)?;
        Ok(session)
    }

    /// Replays the records after the session's latest one, up to `to`.
    pub(crate) fn replay_following(
        &self,
        key: SessionKey,
        session: &mut Session,
        reader: &mut LogReader,
        to: u64,
    ) -> Result<RecordTail, StoreError> {
        let mut tail = RecordTail::default();
        self.database.visit_records(key, session.seq() + 1..=to, |stored| {
            let (record, bytes) = self.read_record(reader, key, &stored)?;
            let format = record.format;
            apply_record(session, record)?;
            let StoredRecord { seq, hash, proof, .. } = stored;
            let now = || session.document().hash_of_format(format).to_string();
            if hash.is_some_and(|hash| hash != now()) {
                return Err(StoreError::HashMismatch { seq });
            }
            if proof.is_some_and(|proof| proof != reader.proof()) {
                return Err(StoreError::ProofMismatch { seq });
            }
            tail.records += 1;
            tail.bytes += bytes as u64;
            Ok(ControlFlow::Continue(()))
        })?;
        Ok(tail)
    }

    /// Reads a stored record. Replaces its references by the values, and also returns the size of its JSON in bytes.
    fn read_record(
        &self,
        reader: &mut LogReader,
        key: SessionKey,
        stored: &StoredRecord,
    ) -> Result<(Record, usize), StoreError> {
        reader.keep_at_most(MAX_HELD_BYTES);
        let seq = stored.seq;
        let read = reader.read_record(&stored.line, &mut |seq| self.database.line(key, seq));
        read.map_err(|error| match error {
            ReadError::Line(reason) => StoreError::DamagedRecord { seq, reason },
            ReadError::Source(error) => error,
        })
    }
}

/// Applies a record from outside to the session.
pub(crate) fn apply_record(session: &mut Session, record: Record) -> Result<(), StoreError> {
    if session.seq() as usize >= edit::MAX_RECORDS {
        return Err(StoreError::TooManyRecords);
    }
    let seq = record.seq;
    let record = record.try_into().map_err(|reason| StoreError::InvalidRecord { seq, reason })?;
    Ok(session.replay(&record)?)
}

/// Writes a batch and returns the growth of its log.
pub(crate) fn insert_batch(
    writer: &Writer,
    FoundSession { key, row }: &FoundSession,
    batch: &CommitBatch<'_>,
) -> Result<RecordTail, StoreError> {
    let (mut proof, mut bytes) = (row.proof.clone(), 0);
    for record in batch.records {
        bytes += insert_record(writer, *key, record.into(), &mut proof)? as u64;
    }
    if let Some(last) = batch.records.last() {
        writer.note_hash(*key, last.seq, &batch.hash.to_string(), &proof)?;
    }
    for rejection in batch.rejections {
        writer.insert_rejection(*key, rejection)?;
    }
    Ok(RecordTail { records: batch.records.len() as u64, bytes })
}

/// Writes a record of session `key`, with references in place of values that the log already contains. Returns the size
/// of its complete JSON in bytes. Advances `proof` to the log's proof after the record.
pub(crate) fn insert_record(
    writer: &Writer,
    key: SessionKey,
    record: Record,
    proof: &mut String,
) -> Result<usize, StoreError> {
    // A record of an earlier format is upgraded, since it may hold references now.
    let record = Record { format: FORMAT, ..record };
    let json = record.to_json();
    if json.len() > MAX_RECORD_BYTES {
        return Err(StoreError::RecordTooLarge);
    }
    let line = compact(&json, record.seq, |hash| writer.position_of_value(key, hash))?;
    writer.insert_record(key, &record, &line)?;
    *proof = next_proof(proof, &line.text);
    Ok(json.len())
}

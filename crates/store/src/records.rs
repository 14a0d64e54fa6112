//! The records of a log: appended together, read one by one.

use document::{DocumentHash, FindScene};
use edit::Session;
use protocol::{FORMAT, LogReader, Place, ReadError, Record, compact, next_proof};
use rusqlite::{ErrorCode, OptionalExtension, Row, Transaction, params};

use crate::checkpoints::Tail;
use crate::operations::{Rejection, insert_rejection};
use crate::sessions::{Found, find, insert_session};
use crate::{MAX_RECORD_BYTES, Store, StoreError};

/// Bytes that [`Store::records`] gives at once, but for a single record that has more.
pub const MAX_PAGE_BYTES: usize = 64 << 20;
/// Bytes of earlier records that are kept in memory while a log is read, for later ones to refer to.
const MAX_HELD_BYTES: usize = 64 << 20;

/// What happened in one session and is committed together.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a> {
    /// The session's name.
    pub session: &'a str,
    /// The records, the next of its log in order. None is no error.
    pub records: &'a [edit::Record],
    /// Operations that were refused meanwhile.
    pub rejections: &'a [Rejection],
    /// Of the document after the last record; replay checks it.
    pub hash: DocumentHash,
}

/// Records of session `?1` from `?2` to `?3`.
pub(crate) const RECORDS: &str =
    "SELECT seq, json, hash, proof FROM record WHERE session = ? AND seq BETWEEN ? AND ? ORDER BY seq";

/// A record as it is stored.
pub(crate) struct Stored {
    pub seq: u64,
    /// Its line in a log file.
    pub line: String,
    /// Of the document after it, where that was noted.
    pub hash: Option<String>,
    /// Of all lines up to it, where that was noted.
    pub proof: Option<String>,
}

impl Store {
    /// Writes all batches down in one transaction: they are on the disk when this returns. On an error none is, but for
    /// [`StoreError::Unknown`]. Gives what each log has grown by.
    pub fn append(&mut self, batches: &[Batch<'_>]) -> Result<Vec<Tail>, StoreError> {
        let transaction = self.writing()?;
        let insert = |batch: &Batch| insert_batch(&transaction, &find(&transaction, batch.session)?, batch);
        let tails = batches.iter().map(insert).collect::<Result<_, _>>()?;
        let committed = transaction.commit();
        committed.map_err(|reason| self.failed_commit(reason))?;
        Ok(tails)
    }

    /// Makes a session called `first.session` that begins with `first`, all of it or, on an error, nothing. Gives its
    /// epoch.
    pub fn begin_session(&mut self, first: &Batch<'_>) -> Result<String, StoreError> {
        let transaction = self.writing()?;
        let (_, epoch) = insert_session(&transaction, first.session)?;
        let found = find(&transaction, first.session)?;
        insert_batch(&transaction, &found, first)?;
        let committed = transaction.commit();
        committed.map_err(|reason| self.failed_commit(reason))?;
        Ok(epoch)
    }

    /// The records from `from` on, in full, at most `limit` and [`MAX_PAGE_BYTES`]; none past the end.
    pub fn records(&self, session: &str, from: u64, limit: usize) -> Result<Vec<Record>, StoreError> {
        let Found { key, row } = find(&self.connection, session)?;
        let mut statement = self.connection.prepare_cached(RECORDS)?;
        let mut reader = LogReader::default();
        let mut bytes = 0;
        let mut page = Vec::new();
        let rows = statement.query_and_then(params![key, from.min(row.seq + 1), row.seq], stored)?;
        for stored in rows.take(limit) {
            let (record, more) = self.read_record(&mut reader, key, &stored?)?;
            bytes += more;
            if bytes > MAX_PAGE_BYTES && !page.is_empty() {
                break;
            }
            page.push(record);
        }
        Ok(page)
    }

    /// The session as it is after record `to`, or after its last, from its log alone. The hash and the proof of each
    /// batch are checked on the way.
    pub fn replay(
        &self,
        session: &str,
        to: Option<u64>,
        find_scene: FindScene,
    ) -> Result<Session, StoreError> {
        let Found { key, row } = find(&self.connection, session)?;
        let to = to.unwrap_or(row.seq);
        if to > row.seq {
            return Err(StoreError::NoRecord { asked: to, last: row.seq });
        }
        let mut session = Session::default();
        self.go_on(key, &mut session, &mut LogReader::default(), to, find_scene)?;
        Ok(session)
    }

    /// Replays the records that follow, up to `to`.
    pub(crate) fn go_on(
        &self,
        key: i64,
        session: &mut Session,
        reader: &mut LogReader,
        to: u64,
        find_scene: FindScene,
    ) -> Result<Tail, StoreError> {
        let mut statement = self.connection.prepare_cached(RECORDS)?;
        let mut tail = Tail::default();
        for stored in statement.query_and_then(params![key, session.seq() + 1, to], stored)? {
            let stored = stored?;
            let (record, bytes) = self.read_record(reader, key, &stored)?;
            take_in(session, record, find_scene)?;
            let Stored { seq, hash, proof, .. } = stored;
            if hash.is_some_and(|hash| hash != session.document().hash().to_string()) {
                return Err(StoreError::Differs { seq });
            }
            if proof.is_some_and(|proof| proof != reader.proof()) {
                return Err(StoreError::Unproven { seq });
            }
            tail.records += 1;
            tail.bytes += bytes as u64;
        }
        Ok(tail)
    }

    /// A stored record in full, and the bytes of its JSON.
    fn read_record(
        &self,
        reader: &mut LogReader,
        key: i64,
        stored: &Stored,
    ) -> Result<(Record, usize), StoreError> {
        reader.keep_at_most(MAX_HELD_BYTES);
        let seq = stored.seq;
        let read = reader.read_record(&stored.line, &mut |seq| self.line(key, seq));
        read.map_err(|error| match error {
            ReadError::Line(reason) => StoreError::DamagedRecord { seq, reason },
            ReadError::Source(error) => error,
        })
    }

    /// The line of record `seq`, with its references.
    pub(crate) fn line(&self, key: i64, seq: u64) -> Result<Option<String>, StoreError> {
        let select = "SELECT json FROM record WHERE session = ? AND seq = ?";
        let mut statement = self.connection.prepare_cached(select)?;
        Ok(statement.query_row(params![key, seq], |row| row.get(0)).optional()?)
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
    Ok(Stored {
        seq: row.get("seq")?,
        line: row.get("json")?,
        hash: row.get("hash")?,
        proof: row.get("proof")?,
    })
}

pub(crate) fn insert_batch(
    transaction: &Transaction<'_>,
    Found { key, row }: &Found,
    batch: &Batch<'_>,
) -> Result<Tail, StoreError> {
    let (mut proof, mut bytes) = (row.proof.clone(), 0);
    for record in batch.records {
        bytes += insert_record(transaction, *key, record.into(), &mut proof)? as u64;
    }
    if let Some(last) = batch.records.last() {
        note_hash(transaction, *key, last.seq, &batch.hash.to_string(), &proof)?;
    }
    for rejection in batch.rejections {
        insert_rejection(transaction, *key, rejection)?;
    }
    Ok(Tail { records: batch.records.len() as u64, bytes })
}

/// Writes a record of session `key` down, what the log holds already referred to; gives the bytes of its JSON in full.
/// `proof` is the log's before and after.
pub(crate) fn insert_record(
    transaction: &Transaction<'_>,
    key: i64,
    record: Record,
    proof: &mut String,
) -> Result<usize, StoreError> {
    // One of an earlier format is upgraded: it may have references now.
    let record = Record { format: FORMAT, ..record };
    let seq = record.seq;
    let json = record.to_json();
    if json.len() > MAX_RECORD_BYTES {
        return Err(StoreError::RecordTooLarge);
    }
    let select = "SELECT record, at FROM held_value WHERE session = ? AND hash = ?";
    let line = compact(&json, seq, |hash| {
        let mut statement = transaction.prepare_cached(select)?;
        let place = |row: &Row<'_>| Ok(Place { record: row.get("record")?, at: row.get("at")? });
        statement.query_row(params![key, hash], place).optional()
    })?;
    let insert = "INSERT INTO record (session, seq, actor, op_id, json) VALUES (?, ?, ?, ?, ?)";
    let row = params![key, seq, record.actor.id, record.op_id, line.text];
    transaction.prepare_cached(insert)?.execute(row).map_err(|error| match error.sqlite_error_code() {
        Some(ErrorCode::ConstraintViolation) => StoreError::OutOfStep(seq),
        _ => error.into(),
    })?;
    let hold = "INSERT INTO held_value (session, hash, record, at) VALUES (?, ?, ?, ?)";
    for (hash, at) in &line.first_holds {
        transaction.prepare_cached(hold)?.execute(params![key, hash, seq, at])?;
    }
    *proof = next_proof(proof, &line.text);
    Ok(json.len())
}

/// Notes the hash of the document after record `seq`, and the proof of the log up to it.
pub(crate) fn note_hash(
    transaction: &Transaction<'_>,
    key: i64,
    seq: u64,
    hash: &str,
    proof: &str,
) -> Result<(), StoreError> {
    let update = "UPDATE record SET hash = ?, proof = ? WHERE session = ? AND seq = ?";
    transaction.prepare_cached(update)?.execute(params![hash, proof, key, seq])?;
    Ok(())
}

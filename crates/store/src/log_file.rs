//! Log files: a log as JSON Lines (SPEC, section 5), read line by line.

use std::collections::HashSet;
use std::io::{BufRead, Read, Write};
use std::ops::ControlFlow;

use document::{AssetHash, EditError};
use edit::{ReplayError, Session};
use protocol::{Checkpoint, FORMAT, FileError, LogHeader, LogLine, LogReader, Record};

use crate::difference::{Difference, DifferingPart};
use crate::records::{apply_record, insert_record};
use crate::sessions::{check_name, insert_session};
use crate::stored::{FoundSession, SessionRow, StoredRecord};
use crate::{MAX_RECORD_BYTES, Store, StoreError};

/// Number of records between two checkpoints of an exported log.
const CHECKPOINT_EVERY: u64 = 10;

/// Result of replaying a log file.
#[derive(Clone, Debug)]
pub struct ReplayedLog {
    /// The session after the last requested record.
    pub session: Session,
    /// The difference at the first checkpoint that does not match.
    pub first_difference: Option<Difference>,
}

/// Replays a log file up to record `to`, or to its end.
pub fn replay_log(log: impl BufRead, to: Option<u64>) -> Result<ReplayedLog, StoreError> {
    visit_log(log, to, |_, _| {})
}

/// Replays like `replay_log`, and calls `visit` with each record and the session after it.
pub fn visit_log(
    log: impl BufRead,
    to: Option<u64>,
    mut visit: impl FnMut(&Record, &Session),
) -> Result<ReplayedLog, StoreError> {
    let (header, lines) = open(log)?;
    let mut differs = None;
    let session = replay_lines(&header, lines, to, |passed| {
        match passed {
            ReplayedLine::Record(record, session) => visit(&record, session),
            ReplayedLine::Checkpoint { difference, .. } => differs = differs.or(difference),
        }
        Ok(())
    })?;
    match (to, session.seq()) {
        (Some(requested), last) if requested > last => Err(StoreError::NoRecord { requested, last }),
        _ => Ok(ReplayedLog { session, first_difference: differs }),
    }
}

impl Store {
    /// Writes the log of `session` as a log file.
    pub fn export(&self, session: &str, out: &mut impl Write) -> Result<(), StoreError> {
        let FoundSession { key, row } = self.database.find(session)?;
        let mut put = |line: String| writeln!(out, "{line}").map_err(StoreError::Unwritable);
        put(row.header().to_json())?;
        let checkpoint = |seq, hash, proof| LogLine::Checkpoint(Checkpoint { seq, hash, proof: Some(proof) }).to_json();
        if row.seq == 0 {
            return put(checkpoint(0, row.hash, row.proof));
        }
        let mut noted = 0;
        self.database.visit_records(key, 1..=row.seq, |StoredRecord { seq, line, hash, proof }| {
            put(line)?;
            if let Some((hash, proof)) = hash.zip(proof)
                && (seq >= noted + CHECKPOINT_EVERY || seq == row.seq)
            {
                put(checkpoint(seq, hash, proof))?;
                noted = seq;
            }
            Ok(ControlFlow::Continue(()))
        })
    }

    /// Makes a session from a log file, completely or, on an error, not at all. Its name is `name`, or else the one in
    /// the log.
    ///
    /// The log is replayed meanwhile. Errors are gaps, records that do not apply, checkpoints that differ, and scenes
    /// for which `is_here` returns false.
    pub fn import(
        &mut self,
        log: impl BufRead,
        name: Option<&str>,
        is_here: &dyn Fn(&AssetHash) -> bool,
    ) -> Result<SessionRow, StoreError> {
        let (header, lines) = open(log)?;
        self.database.write(|writer| {
            let name = name.unwrap_or(&header.session);
            let (key, _) = insert_session(writer, name, None, FORMAT)?;
            // The proof covers the lines as stored, in this version's format, even if the file has an earlier one.
            let mut proof = writer.find(name)?.row.proof;
            replay_lines(&header, lines, None, |passed| match passed {
                ReplayedLine::Record(record, session) => {
                    check_scene(record.seq, session, is_here)?;
                    insert_record(writer, key, *record, &mut proof).map(drop)
                }
                ReplayedLine::Checkpoint { difference: Some(difference), .. } => {
                    Err(StoreError::CheckpointMismatch(difference))
                }
                ReplayedLine::Checkpoint { seq: 0, .. } => Ok(()),
                ReplayedLine::Checkpoint { seq, hash, .. } => writer.note_hash(key, seq, &hash, &proof),
            })?;
            Ok(writer.find(name)?.row)
        })
    }
}

/// Refuses the same logs and names as [`Store::import`] and writes nothing.
pub fn check_log(
    log: impl BufRead,
    name: Option<&str>,
    is_here: &dyn Fn(&AssetHash) -> bool,
) -> Result<(), StoreError> {
    let (header, lines) = open(log)?;
    check_name(name.unwrap_or(&header.session))?;
    replay_lines(&header, lines, None, |passed| match passed {
        ReplayedLine::Record(record, session) => check_scene(record.seq, session, is_here),
        ReplayedLine::Checkpoint { difference: Some(difference), .. } => {
            Err(StoreError::CheckpointMismatch(difference))
        }
        ReplayedLine::Checkpoint { .. } => Ok(()),
    })?;
    Ok(())
}

/// Refuses a scene whose bytes are missing.
fn check_scene(seq: u64, session: &Session, is_here: &dyn Fn(&AssetHash) -> bool) -> Result<(), StoreError> {
    match session.document().scene().map(|scene| scene.asset) {
        Some(asset) if !is_here(&asset) => {
            Err(ReplayError::Record { seq, reason: EditError::UnknownAsset(asset) }.into())
        }
        _ => Ok(()),
    }
}

/// A line of a log file that was just replayed.
enum ReplayedLine<'a> {
    /// The record and the session after it.
    Record(Box<Record>, &'a Session),
    /// `hash` is the document's hash in this version's format.
    Checkpoint { seq: u64, hash: String, difference: Option<Difference> },
}

/// Replays the lines after the header up to record `to` and its checkpoint, or to the end. Calls `visit` for each line.
fn replay_lines(
    header: &LogHeader,
    mut lines: Lines<impl BufRead>,
    to: Option<u64>,
    mut visit: impl FnMut(ReplayedLine<'_>) -> Result<(), StoreError>,
) -> Result<Session, StoreError> {
    let mut session = Session::default();
    let mut reader = LogReader::going_on_from(&header.first_proof(lines.line()?));
    let mut right_up_to = 0;
    let mut operations = HashSet::new();
    let mut is_whole = false;
    // Format of the latest record. Its checkpoint's hash has the same format.
    let mut format = header.format;
    while let Some(line) = lines.next(|line| reader.read(line))? {
        let follows_checkpoint = is_whole;
        is_whole = matches!(line, LogLine::Checkpoint(_));
        match line {
            LogLine::Record(record) if to.is_some_and(|to| record.seq > to) => return Ok(session),
            LogLine::Record(record) => {
                let (seq, op_id) = (record.seq, record.op_id.clone());
                format = record.format;
                apply_record(&mut session, Record::clone(&record))?;
                if !operations.insert((record.actor.id.clone(), op_id.clone())) {
                    return Err(StoreError::RepeatedOperation { seq, op_id });
                }
                visit(ReplayedLine::Record(record, &session))?;
            }
            LogLine::Checkpoint(Checkpoint { seq: found, .. }) if follows_checkpoint || found != session.seq() => {
                return Err(StoreError::MisplacedCheckpoint { line: lines.number, found });
            }
            LogLine::Checkpoint(Checkpoint { seq, hash, proof }) => {
                let is_proven = proof.map_or(header.format == 1, |proof| proof == reader.proof());
                let document = session.document();
                let of = match (hash == document.hash_of_format(format).to_string(), is_proven) {
                    (true, true) => None,
                    (true, false) if lines.end_in_cr_lf => Some(DifferingPart::LineEnds),
                    (true, false) => Some(DifferingPart::Lines),
                    (false, _) => Some(DifferingPart::Document),
                };
                let difference = of.map(|of| Difference { part: of, last_matching_seq: right_up_to, seq });
                right_up_to = seq;
                visit(ReplayedLine::Checkpoint { seq, hash: document.hash().to_string(), difference })?;
            }
        }
    }
    if is_whole { Ok(session) } else { Err(StoreError::Truncated) }
}

/// Reads the header and returns it with the following lines.
fn open<R: BufRead>(log: R) -> Result<(LogHeader, Lines<R>), StoreError> {
    let mut lines = Lines { log, number: 0, text: Vec::new(), end_in_cr_lf: false };
    let header = lines.next(LogHeader::parse)?.ok_or(StoreError::Truncated)?;
    Ok((header, lines))
}

/// Lines of a file, one in memory at a time.
struct Lines<R> {
    log: R,
    /// Number of the latest line, from 1.
    number: u64,
    text: Vec<u8>,
    /// True once a line ended in CR LF.
    end_in_cr_lf: bool,
}

impl<R: BufRead> Lines<R> {
    /// Parses the next line. Returns `None` after the last one. A line may be as long as a record.
    fn next<T>(&mut self, parse: impl FnOnce(&str) -> Result<T, FileError>) -> Result<Option<T>, StoreError> {
        self.text.clear();
        let limit = MAX_RECORD_BYTES as u64 + 1;
        self.log.by_ref().take(limit).read_until(b'\n', &mut self.text).map_err(StoreError::Unreadable)?;
        if self.text.is_empty() {
            return Ok(None);
        }
        self.number += 1;
        if self.text.len() > MAX_RECORD_BYTES {
            return Err(StoreError::RecordTooLarge);
        }
        let line = self.number;
        self.end_in_cr_lf |= self.text.ends_with(b"\r\n");
        parse(self.line()?).map(Some).map_err(|reason| StoreError::Line { line, reason })
    }

    /// Returns the latest line without its line feed.
    fn line(&self) -> Result<&str, StoreError> {
        let text = str::from_utf8(&self.text).map_err(|_| StoreError::NotUtf8 { line: self.number })?;
        Ok(text.strip_suffix('\n').unwrap_or(text))
    }
}

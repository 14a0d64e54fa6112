//! Log files: a log as JSON Lines (SPEC, section 5), read line by line.

use std::collections::HashSet;
use std::io::{BufRead, Read, Write};
use std::ops::ControlFlow;

use document::{AssetHash, EditError};
use edit::{ReplayError, Session};
use protocol::{Checkpoint, FIRST_PROOF, FORMAT, FileError, LogHeader, LogLine, LogReader, Record};

use crate::records::{insert_record, take_in};
use crate::sessions::insert_session;
use crate::stored::{Found, SessionRow, StoredRecord};
use crate::{MAX_RECORD_BYTES, Store, StoreError};

/// Records between two checkpoints of an exported log.
const CHECKPOINT_EVERY: u64 = 10;

/// What a log file comes to.
#[derive(Clone, Debug)]
pub struct ReplayedLog {
    /// The session after the last record that was asked for.
    pub session: Session,
    /// The first record whose checkpoint says another hash than the document has after it, or another proof than the
    /// lines have.
    pub differs: Option<u64>,
}

/// Replays a log file up to record `to`, or to its end.
pub fn replay_log(log: impl BufRead, to: Option<u64>) -> Result<ReplayedLog, StoreError> {
    visit_log(log, to, |_, _| {})
}

/// The same, with `visit` told each record and the session after it.
pub fn visit_log(
    log: impl BufRead,
    to: Option<u64>,
    mut visit: impl FnMut(&Record, &Session),
) -> Result<ReplayedLog, StoreError> {
    let (header, lines) = open(log)?;
    let mut differs = None;
    let session = walk(&header, lines, to, |passed| {
        match passed {
            Passed::Record(record, session) => visit(&record, session),
            Passed::Checkpoint { seq, holds: false, .. } => differs = differs.or(Some(seq)),
            Passed::Checkpoint { .. } => {}
        }
        Ok(())
    })?;
    match (to, session.seq()) {
        (Some(asked), last) if asked > last => Err(StoreError::NoRecord { asked, last }),
        _ => Ok(ReplayedLog { session, differs }),
    }
}

impl Store {
    /// Writes the log of `session` as a log file.
    pub fn export(&self, session: &str, out: &mut impl Write) -> Result<(), StoreError> {
        let Found { key, row } = self.database.find(session)?;
        let mut put = |line: String| writeln!(out, "{line}").map_err(StoreError::Unwritable);
        put(LogHeader { format: FORMAT, session: row.name.clone() }.to_json())?;
        let checkpoint =
            |seq, hash, proof| LogLine::Checkpoint(Checkpoint { seq, hash, proof: Some(proof) }).to_json();
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

    /// Makes a session of a log file, all of it or, on an error, nothing. It is called `name`, or as the log says.
    ///
    /// The log is replayed on the way: gaps, records that do not fit and checkpoints that differ are refused, and
    /// scenes of which `is_here` says that their bytes are not.
    pub fn import(
        &mut self,
        log: impl BufRead,
        name: Option<&str>,
        is_here: &dyn Fn(&AssetHash) -> bool,
    ) -> Result<SessionRow, StoreError> {
        let (header, lines) = open(log)?;
        self.database.write(|writer| {
            let name = name.unwrap_or(&header.session);
            let (key, _) = insert_session(writer, name)?;
            // Of the lines as they are stored, in this version's format, whatever the file's was.
            let mut proof = FIRST_PROOF.to_owned();
            walk(&header, lines, None, |passed| match passed {
                Passed::Record(record, session) => {
                    let (seq, scene) = (record.seq, session.document().scene());
                    if let Some(asset) = scene.map(|scene| scene.asset).filter(|asset| !is_here(asset)) {
                        let reason = EditError::UnknownAsset(asset);
                        return Err(ReplayError::Record { seq, reason }.into());
                    }
                    insert_record(writer, key, *record, &mut proof).map(drop)
                }
                Passed::Checkpoint { seq: 0, holds: true, .. } => Ok(()),
                Passed::Checkpoint { seq, hash, holds: true } => writer.note_hash(key, seq, &hash, &proof),
                Passed::Checkpoint { seq, holds: false, .. } => Err(StoreError::Differs { seq }),
            })?;
            Ok(writer.find(name)?.row)
        })
    }
}

/// A line of a log file that the replay has passed.
enum Passed<'a> {
    /// The session is the one after it.
    Record(Box<Record>, &'a Session),
    /// `holds`: the document has the hash that the checkpoint says, and the lines have its proof. `hash` is the document's
    /// in this version's format.
    Checkpoint { seq: u64, hash: String, holds: bool },
}

/// Replays the lines after the first up to record `to` and what is said of it, or to the end. `visit` is told each.
fn walk(
    header: &LogHeader,
    mut lines: Lines<impl BufRead>,
    to: Option<u64>,
    mut visit: impl FnMut(Passed<'_>) -> Result<(), StoreError>,
) -> Result<Session, StoreError> {
    let mut session = Session::default();
    let mut reader = LogReader::default();
    let mut operations = HashSet::new();
    let mut is_whole = false;
    // Of the latest record, by which its checkpoint's hash is made.
    let mut format = header.format;
    while let Some(line) = lines.next(|line| reader.read(line))? {
        let follows_checkpoint = is_whole;
        is_whole = matches!(line, LogLine::Checkpoint(_));
        match line {
            LogLine::Record(record) if to.is_some_and(|to| record.seq > to) => return Ok(session),
            LogLine::Record(record) => {
                let (seq, op_id) = (record.seq, record.op_id.clone());
                format = record.format;
                take_in(&mut session, Record::clone(&record))?;
                if !operations.insert((record.actor.id.clone(), op_id.clone())) {
                    return Err(StoreError::Repeated { seq, op_id });
                }
                visit(Passed::Record(record, &session))?;
            }
            LogLine::Checkpoint(Checkpoint { seq: found, .. })
                if follows_checkpoint || found != session.seq() =>
            {
                return Err(StoreError::Misplaced { line: lines.number, found });
            }
            LogLine::Checkpoint(Checkpoint { seq, hash, proof }) => {
                let is_proven = proof.map_or(header.format == 1, |proof| proof == reader.proof());
                let document = session.document();
                let holds = is_proven && hash == document.hash_of_format(format).to_string();
                visit(Passed::Checkpoint { seq, hash: document.hash().to_string(), holds })?;
            }
        }
    }
    if is_whole { Ok(session) } else { Err(StoreError::Cut) }
}

/// The first line of a log file, and those after it.
fn open<R: BufRead>(log: R) -> Result<(LogHeader, Lines<R>), StoreError> {
    let mut lines = Lines { log, number: 0, text: Vec::new() };
    let header = lines.next(LogHeader::parse)?.ok_or(StoreError::Cut)?;
    Ok((header, lines))
}

/// Lines of a file, one in memory at a time.
struct Lines<R> {
    log: R,
    /// Of the line last read, from 1.
    number: u64,
    text: Vec<u8>,
}

impl<R: BufRead> Lines<R> {
    /// What the next line says; `None` after the last. A line may be as long as a record.
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
        let text = str::from_utf8(&self.text).map_err(|_| StoreError::NotText { line })?;
        let text = text.strip_suffix('\n').unwrap_or(text);
        parse(text).map(Some).map_err(|reason| StoreError::Line { line, reason })
    }
}

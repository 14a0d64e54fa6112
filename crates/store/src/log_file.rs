//! Log files: a log as JSON Lines (SPEC, section 5), read line by line.

use std::io::{BufRead, Read, Write};

use edit::Session;
use protocol::{Checkpoint, FORMAT, FileError, LogHeader, LogLine, Record};
use rusqlite::params;
use scene::FindScene;

use crate::records::{RECORDS, Stored, insert_record, note_hash, stored, take_in};
use crate::sessions::{find, insert_session};
use crate::{MAX_RECORD_BYTES, SessionRow, Store, StoreError};

/// Records between two checkpoints of an exported log.
const CHECKPOINT_EVERY: u64 = 10;

/// What a log file comes to.
#[derive(Clone, Debug)]
pub struct ReplayedLog {
    /// The session after the last record that was asked for.
    pub session: Session,
    /// The first record whose checkpoint says another hash than the document has after it.
    pub differs: Option<u64>,
}

/// Replays a log file up to record `to`, or to its end.
pub fn replay_log(
    log: impl BufRead,
    to: Option<u64>,
    find_scene: FindScene,
) -> Result<ReplayedLog, StoreError> {
    let (_, lines) = open(log)?;
    let mut differs = None;
    let session = walk(lines, to, find_scene, |passed| {
        if let Passed::Checkpoint { seq, holds: false, .. } = passed {
            differs = differs.or(Some(seq));
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
        let (key, row) = find(&self.connection, session)?;
        let mut put = |line: String| writeln!(out, "{line}").map_err(StoreError::Unwritable);
        put(LogHeader { format: FORMAT, session: row.name.clone() }.to_json())?;
        let checkpoint = |seq, hash| LogLine::Checkpoint(Checkpoint { seq, hash }).to_json();
        if row.seq == 0 {
            return put(checkpoint(0, row.hash));
        }
        let mut noted = 0;
        let mut statement = self.connection.prepare_cached(RECORDS)?;
        for stored in statement.query_and_then(params![key, 1, row.seq], stored)? {
            let Stored { record, hash, .. } = stored?;
            let seq = record.seq;
            put(LogLine::Record(Box::new(record)).to_json())?;
            if let Some(hash) = hash
                && (seq >= noted + CHECKPOINT_EVERY || seq == row.seq)
            {
                put(checkpoint(seq, hash))?;
                noted = seq;
            }
        }
        Ok(())
    }

    /// Makes a session of a log file, all of it or, on an error, nothing. It is called `name`, or as the log says.
    ///
    /// The log is replayed on the way: gaps, records that do not fit and checkpoints that differ are refused.
    pub fn import(
        &mut self,
        log: impl BufRead,
        name: Option<&str>,
        find_scene: FindScene,
    ) -> Result<SessionRow, StoreError> {
        let (header, lines) = open(log)?;
        let transaction = self.writing()?;
        let name = name.unwrap_or(&header.session);
        let (key, _) = insert_session(&transaction, name)?;
        walk(lines, None, find_scene, |passed| match passed {
            Passed::Record(record) => insert_record(&transaction, key, record, None),
            Passed::Checkpoint { seq: 0, holds: true, .. } => Ok(()),
            Passed::Checkpoint { seq, hash, holds: true } => note_hash(&transaction, key, seq, &hash),
            Passed::Checkpoint { seq, holds: false, .. } => Err(StoreError::Differs { seq }),
        })?;
        let (_, row) = find(&transaction, name)?;
        transaction.commit()?;
        Ok(row)
    }
}

/// A line of a log file that the replay has passed.
enum Passed {
    Record(Box<Record>),
    /// `holds`: the document has that hash.
    Checkpoint {
        seq: u64,
        hash: String,
        holds: bool,
    },
}

/// Replays the lines after the first up to record `to` and what is said of it, or to the end. `visit` is told each.
fn walk(
    mut lines: Lines<impl BufRead>,
    to: Option<u64>,
    find_scene: FindScene,
    mut visit: impl FnMut(Passed) -> Result<(), StoreError>,
) -> Result<Session, StoreError> {
    let mut session = Session::default();
    let mut is_whole = false;
    while let Some(line) = lines.next(LogLine::parse)? {
        is_whole = matches!(line, LogLine::Checkpoint(_));
        match line {
            LogLine::Record(record) if to.is_some_and(|to| record.seq > to) => return Ok(session),
            LogLine::Record(record) => {
                take_in(&mut session, Record::clone(&record), find_scene)?;
                visit(Passed::Record(record))?;
            }
            LogLine::Checkpoint(Checkpoint { seq: found, .. }) if found != session.seq() => {
                return Err(StoreError::Misplaced { line: lines.number, found, after: session.seq() });
            }
            LogLine::Checkpoint(Checkpoint { seq, hash }) => {
                let holds = hash == session.document().hash().to_string();
                visit(Passed::Checkpoint { seq, hash, holds })?;
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
    fn next<T>(&mut self, parse: impl Fn(&str) -> Result<T, FileError>) -> Result<Option<T>, StoreError> {
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
        parse(text).map(Some).map_err(|reason| StoreError::Line { line, reason })
    }
}

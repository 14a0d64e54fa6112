//! Log files: a header, records and checkpoints, a line each (SPEC, section 5), proven on the way.

use std::convert::Infallible;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use sha2::{Digest, Sha256};

use crate::error::from_json;
use crate::held::{LineCache, MIN_HELD_BYTES};
use crate::log_line::{FindLine, ReadError, to_line};
use crate::record::check_format;
use crate::{FileError, Record};

/// The first line of a log file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LogHeader {
    /// [`crate::FORMAT`] of the program that made the session.
    pub format: u32,
    /// Name of the session.
    pub session: String,
}

/// What the document's hash is after a record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Checkpoint {
    /// The record; 0 is the empty document before the first.
    pub seq: u64,
    /// Of the document, 64 hexadecimal digits.
    pub hash: String,
    /// Of the header and all lines of records up to there ([`next_proof`]), 64 hexadecimal digits. Logs of format 1 have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<String>,
}

/// A line that says what the hash is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckpointLine {
    /// The checkpoint.
    pub checkpoint: Checkpoint,
}

/// Any line after the first.
#[derive(Clone, Debug, PartialEq)]
pub enum LogLine {
    /// A step.
    Record(Box<Record>),
    /// A hash.
    Checkpoint(Checkpoint),
}

/// The proof before the first record in logs of formats 2 and 3, which does not cover the header.
pub const FIRST_PROOF: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// The proof after one more record: SHA-256 over the proof before, its 64 digits, and the record's line as it stands
/// in the log, without its end. So it covers all that a record says, who did it, when and under which name included.
pub fn next_proof(before: &str, line: &str) -> String {
    format!("{:x}", Sha256::new().chain_update(before).chain_update(line).finalize())
}

/// Reads the lines of a log after its header, in order: resolves references and keeps the proof.
#[derive(Clone, Debug)]
pub struct LogReader {
    held: LineCache,
    proof: String,
}

impl Default for LogReader {
    /// Reads lines whose proof nobody asks for, or those of a log of format 3 or earlier.
    fn default() -> Self {
        Self::going_on_from(FIRST_PROOF)
    }
}

impl LogReader {
    /// Reads a log from its first record.
    pub fn new(header: &LogHeader) -> Self {
        Self::going_on_from(&header.first_proof(&header.to_json()))
    }

    /// Goes on behind a record whose proof is known. What the records before it hold is asked for when it is needed.
    pub fn going_on_from(proof: &str) -> Self {
        Self { held: LineCache::default(), proof: proof.into() }
    }

    /// The proof of all records read so far.
    pub fn proof(&self) -> &str {
        &self.proof
    }

    /// Reads one line of a file that has all records from the first.
    pub fn read(&mut self, line: &str) -> Result<LogLine, FileError> {
        // Checkpoints are told apart by their only field, so that the reason for a refusal names the place in the
        // shape that was meant.
        if line.trim_start().starts_with("{\"checkpoint\"") {
            return from_json::<CheckpointLine>(line).map(|line| LogLine::Checkpoint(line.checkpoint));
        }
        let none_before: &mut FindLine<Infallible> = &mut |_| Ok(None);
        match self.read_record(line, none_before) {
            Ok((record, _)) => Ok(LogLine::Record(Box::new(record))),
            Err(ReadError::Line(reason)) => Err(reason),
        }
    }

    /// Reads the line of one record; also gives the bytes of its JSON in full. `find_line` gives the lines of earlier
    /// records, where they can be had.
    pub fn read_record<E>(
        &mut self,
        line: &str,
        find_line: &mut FindLine<E>,
    ) -> Result<(Record, usize), ReadError<E>> {
        let record = self.resolve(line, find_line)?;
        self.proof = next_proof(&self.proof, line);
        Ok(record)
    }

    /// Lets go of what is kept of earlier records once that has more than `most_bytes`.
    pub fn keep_at_most(&mut self, max_bytes: usize) {
        if self.held.bytes() > max_bytes {
            self.held = LineCache::default();
        }
    }

    fn resolve<E>(
        &mut self,
        line: &str,
        find_line: &mut FindLine<E>,
    ) -> Result<(Record, usize), ReadError<E>> {
        // What is short neither holds a long value nor has one left out, and format 1 had no references.
        if line.len() <= MIN_HELD_BYTES && !line.contains("\"sameAs\"") {
            return Ok((Record::parse(line)?, line.len()));
        }
        let Numbered { format, seq } = numbered(line)?;
        if format == 1 {
            return Ok((Record::parse(line)?, line.len()));
        }
        let text = self.held.expand(line, seq, find_line)?;
        Ok((Record::parse(&text)?, text.len()))
    }
}

#[derive(Deserialize)]
struct Numbered {
    format: u32,
    seq: u64,
}

/// Which record a line is, before the rest is looked at.
fn numbered(line: &str) -> Result<Numbered, FileError> {
    let numbered: Numbered = from_json(line)?;
    check_format(numbered.format).map_err(FileError::Format)?;
    Ok(numbered)
}

impl LogLine {
    /// The line, without its end.
    pub fn to_json(&self) -> String {
        match self {
            Self::Record(record) => to_line(record),
            Self::Checkpoint(checkpoint) => to_line(&CheckpointLine { checkpoint: checkpoint.clone() }),
        }
    }
}

impl LogHeader {
    /// Reads the first line.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let header: Self = from_json(text)?;
        check_format(header.format).map_err(FileError::Format)?;
        Ok(header)
    }

    /// The line, without its end.
    pub fn to_json(&self) -> String {
        to_line(self)
    }

    /// The proof before the first record, where the header stands in the log as `line`, without its end (SPEC, LOG-4).
    pub fn first_proof(&self, line: &str) -> String {
        match self.format {
            ..4 => FIRST_PROOF.to_owned(),
            _ => next_proof("", line),
        }
    }
}

//! Log files: a header, then records and checkpoints, one per line (SPEC, section 5). Reading computes the
//! proof.

use std::convert::Infallible;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use sha2::{Digest, Sha256};

use crate::error::{check_format, from_json};
use crate::held::{LineCache, MIN_HELD_BYTES};
use crate::log_line::{FindLine, ReadError, to_line};
use crate::{FileError, Record};

/// First line of a log file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LogHeader {
    /// Format of the program that created the session, see [`crate::FORMAT`].
    pub format: u32,
    /// Name of the session.
    pub session: String,
}

/// Hash of the document after a record.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct Checkpoint {
    /// Sequence number of the record; 0 for the empty document before the first.
    pub seq: u64,
    /// Hash of the document, 64 hexadecimal digits.
    pub hash: String,
    /// Proof of the header and of all lines of records up to this one ([`next_proof`]), 64 hexadecimal digits.
    /// Logs of format 1 have none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub proof: Option<String>,
}

/// Line of a log with a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CheckpointLine {
    pub checkpoint: Checkpoint,
}

/// Line of a log after the header.
#[derive(Clone, Debug, PartialEq)]
pub enum LogLine {
    Record(Box<Record>),
    Checkpoint(Checkpoint),
}

/// Proof before the first record in logs of formats 2 and 3, which does not cover the header.
pub const FIRST_PROOF: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// Computes the proof after one more record: SHA-256 over the 64 digits of the proof before, and over the
/// record's line in the log, without the line end. So the proof covers the whole record, including actor, time
/// and operation id.
pub fn next_proof(before: &str, line: &str) -> String {
    let hash = Sha256::new().chain_update(before).chain_update(line).finalize();
    const_hex::const_encode::<32, false>(&hash.into()).as_str().into()
}

/// Reader of the lines of a log after its header, in order. It replaces each reference to a value in an earlier line by
/// that value, and updates the proof ([`next_proof`]).
#[derive(Clone, Debug)]
pub struct LogReader {
    held: LineCache,
    proof: String,
}

impl Default for LogReader {
    /// Returns a reader for lines whose proof is not needed, or for a log of format 3 or earlier.
    fn default() -> Self {
        Self::going_on_from(FIRST_PROOF)
    }
}

impl LogReader {
    /// Returns a reader that starts at the first record.
    pub fn new(header: &LogHeader) -> Self {
        Self::going_on_from(&header.first_proof(&header.to_json()))
    }

    /// Returns a reader that starts after the record up to which the log has this proof ([`next_proof`]). The reader
    /// asks for an earlier line when a record refers to a value in it.
    pub fn going_on_from(proof: &str) -> Self {
        Self { held: LineCache::default(), proof: proof.into() }
    }

    /// Returns the proof of all records read so far.
    pub fn proof(&self) -> &str {
        &self.proof
    }

    /// Reads a line of a file that has all records from the first.
    pub fn read(&mut self, line: &str) -> Result<LogLine, FileError> {
        // A checkpoint is recognized by its only field. So an error names the field of the right shape.
        if line.trim_start().starts_with("{\"checkpoint\"") {
            return from_json::<CheckpointLine>(line).map(|line| LogLine::Checkpoint(line.checkpoint));
        }
        let none_before: &mut FindLine<Infallible> = &mut |_| Ok(None);
        match self.read_record(line, none_before) {
            Ok((record, _)) => Ok(LogLine::Record(Box::new(record))),
            Err(ReadError::Line(reason)) => Err(reason),
        }
    }

    /// Reads the line of a record. Also returns the bytes of its JSON in full. `find_line` returns the lines of
    /// earlier records, if they are available.
    pub fn read_record<E>(&mut self, line: &str, find_line: &mut FindLine<E>) -> Result<(Record, usize), ReadError<E>> {
        let record = self.resolve(line, find_line)?;
        self.proof = next_proof(&self.proof, line);
        Ok(record)
    }

    /// Evicts the cached lines of earlier records if they have more than `max_bytes`.
    pub fn keep_at_most(&mut self, max_bytes: usize) {
        if self.held.bytes() > max_bytes {
            self.held = LineCache::default();
        }
    }

    fn resolve<E>(&mut self, line: &str, find_line: &mut FindLine<E>) -> Result<(Record, usize), ReadError<E>> {
        // A short line holds no long value and lacks none, and format 1 had no references.
        if line.len() <= MIN_HELD_BYTES && !line.contains("\"sameAs\"") {
            return Ok((Record::parse(line)?, line.len()));
        }
        // Only format and sequence number, before the whole line is parsed.
        let Numbered { format, seq } = from_json(line)?;
        check_format(format).map_err(FileError::Format)?;
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

impl LogLine {
    /// Serializes the record or checkpoint as a line of a log, without the line end.
    pub fn to_json(&self) -> String {
        match self {
            Self::Record(record) => to_line(record),
            Self::Checkpoint(checkpoint) => to_line(&CheckpointLine { checkpoint: checkpoint.clone() }),
        }
    }
}

impl LogHeader {
    /// Parses the first line.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        let header: Self = from_json(text)?;
        check_format(header.format).map_err(FileError::Format)?;
        Ok(header)
    }

    /// Serializes the header as the first line of a log, without the line end.
    pub fn to_json(&self) -> String {
        to_line(self)
    }

    /// Computes the proof before the first record. `line` is the header in the log, without the line end (SPEC,
    /// LOG-4).
    pub fn first_proof(&self, line: &str) -> String {
        if self.format < 4 { FIRST_PROOF.to_owned() } else { next_proof("", line) }
    }
}

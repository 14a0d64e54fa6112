//! Log files: a header, records and checkpoints, a line each (SPEC, section 5).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::from_json;
use crate::record::known_format;
use crate::{FileError, Record};

/// The first line of a log file.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
pub struct LogHeader {
    /// [`crate::FORMAT`] of the newest record.
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
    /// 64 hexadecimal digits.
    pub hash: String,
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

impl LogLine {
    /// Reads one line.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        // Checkpoints are told apart by their only field, so that the reason for a refusal names the place in the
        // shape that was meant.
        if text.trim_start().starts_with("{\"checkpoint\"") {
            return from_json::<CheckpointLine>(text).map(|line| Self::Checkpoint(line.checkpoint));
        }
        Record::parse(text).map(|record| Self::Record(Box::new(record)))
    }

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
        known_format(header.format)?;
        Ok(header)
    }

    /// The line, without its end.
    pub fn to_json(&self) -> String {
        to_line(self)
    }
}

fn to_line(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("plain data with string keys")
}

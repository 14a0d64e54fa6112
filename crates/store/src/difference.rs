//! Differences between a log file and the log that was written.

use std::fmt;

/// The first difference between a log file and the log that was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Difference {
    pub part: DifferingPart,
    /// Latest record up to which log file and written log are equal.
    pub last_matching_seq: u64,
    /// Record whose checkpoint differs.
    pub seq: u64,
}

/// Part of a log file that can differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DifferingPart {
    /// Document after its records.
    Document,
    /// Lines only, without an effect on the document: an actor, a time or the session's name.
    Lines,
    LineEnds,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { part: of, last_matching_seq: right_up_to, seq } = self;
        let header = if *right_up_to == 0 { "the header or " } else { "" };
        let first = right_up_to + 1;
        match of {
            DifferingPart::Document => write!(
                f,
                "the document after record {seq} is not the one that was logged: a value in records {first} to {seq} was \
                 changed, or the program that applies them; export the log again"
            ),
            DifferingPart::Lines => write!(
                f,
                "{header}a line of records {first} to {seq} is not what was logged, though they come to the same document: \
                 who did something, when, or a name was changed; export the log again"
            ),
            DifferingPart::LineEnds => write!(
                f,
                "its lines end in CR LF and are not what was logged: it was copied as text for Windows; copy it as it \
                 is, or export the log again"
            ),
        }
    }
}

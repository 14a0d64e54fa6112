//! Values that a log holds already: written once, referred to afterwards (SPEC, REC-6).
//!
//! All of this works on the text of lines and knows no field but `sameAs`: what is long and comes again is written
//! short, whatever a record will hold one day.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::log_line::{FindLine, ReadError, to_line};
use crate::{FileError, MAX_RECORD_BYTES};

/// Objects and arrays with more bytes of JSON than this are written once.
pub const MIN_HELD_BYTES: usize = 1_024;
/// How deep values that are referred to may refer on. Each is a part of the one before, and so it is never more than the
/// depth of a record's JSON.
const MAX_DEPTH: usize = 16;

/// How a reference begins. Inside a string it cannot stand like that: there its quotes are escaped.
const REFERENCE_PREFIX: &str = r#"{"sameAs":"#;

/// Where in a log a value stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LogPosition {
    /// Sequence of the record that holds it.
    pub record: u64,
    /// The byte of the record's line at which the value begins.
    pub at: usize,
}

/// Stands instead of a value that the log holds already.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct Reference {
    same_as: Target,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Target {
    record: u64,
    at: usize,
    /// SHA-256 of the value's JSON in full, 64 hexadecimal digits.
    hash: String,
}

/// A record's line, with references.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CompactLine {
    /// The line, without its end.
    pub text: String,
    /// The values that it is the first to hold: the hash of each in full, and where it begins.
    pub new_values: Vec<(String, usize)>,
}

/// Shortens the JSON of record `seq`, which has no references. `find_place` tells where the value of a hash stands, if
/// the log holds it.
pub fn compact<E>(
    text: &str,
    seq: u64,
    find_place: impl FnMut(&str) -> Result<Option<LogPosition>, E>,
) -> Result<CompactLine, E> {
    let mut spans = long_values(text);
    // Outer ones first.
    spans.sort_by_key(|span| (span.start, std::cmp::Reverse(span.end)));
    let line = CompactLine { text: String::with_capacity(text.len()), new_values: Vec::new() };
    let own = HashMap::new();
    let mut writer = CompactLineWriter { text, seq, find_place, new_positions: own, copied: 0, line };
    let mut written_to = 0;
    for span in spans {
        // Within a value that was replaced?
        if span.start >= written_to {
            written_to = writer.write(span)?;
        }
    }
    writer.copy_to(text.len());
    Ok(writer.line)
}

/// A line that is being shortened.
struct CompactLineWriter<'a, F> {
    text: &'a str,
    seq: u64,
    find_place: F,
    /// Where the values begin that this line is the first to hold.
    new_positions: HashMap<String, usize>,
    /// How much of the text is written.
    copied: usize,
    line: CompactLine,
}

impl<E, F: FnMut(&str) -> Result<Option<LogPosition>, E>> CompactLineWriter<'_, F> {
    /// Writes a reference to the value where it is held, else all that stands before the value. Returns up to where
    /// nothing is left to write.
    fn write(&mut self, span: Range<usize>) -> Result<usize, E> {
        let hash = hash(&self.text[span.clone()]);
        let own = self.new_positions.get(&hash).map(|&at| LogPosition { record: self.seq, at });
        let place = if own.is_some() { own } else { (self.find_place)(&hash)? };
        self.copy_to(span.start);
        if let Some(LogPosition { record, at }) = place {
            let reference = Reference { same_as: Target { record, at, hash } };
            self.line.text.push_str(&to_line(&reference));
            self.copied = span.end;
        } else {
            let at = self.line.text.len();
            self.new_positions.insert(hash.clone(), at);
            self.line.new_values.push((hash, at));
        }
        Ok(self.copied)
    }

    fn copy_to(&mut self, end: usize) {
        self.line.text.push_str(&self.text[self.copied..end]);
        self.copied = end;
    }
}

/// The lines that later ones may refer to.
#[derive(Clone, Debug, Default)]
pub(crate) struct LineCache {
    lines: HashMap<u64, Arc<str>>,
    bytes: usize,
}

impl LineCache {
    /// Keeps the line of record `seq`.
    pub fn keep(&mut self, line: &str, seq: u64) -> Arc<str> {
        let line: Arc<str> = line.into();
        if self.lines.insert(seq, Arc::clone(&line)).is_none() {
            self.bytes += line.len();
        }
        line
    }

    /// The JSON in full of record `seq`, which has at most [`MAX_RECORD_BYTES`]. Its line is kept, and those that it
    /// refers to.
    pub fn expand<E>(
        &mut self,
        line: &str,
        seq: u64,
        find_line: &mut FindLine<E>,
    ) -> Result<String, ReadError<E>> {
        let line = self.keep(line, seq);
        let mut whole = String::with_capacity(line.len());
        let mut part = LineExpansion { held: self, of: seq, find_line, whole: &mut whole };
        part.expand(&line, LogPosition { record: seq, at: 0 }, line.len(), MAX_DEPTH)?;
        Ok(whole)
    }

    /// Bytes of the lines that are kept.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

/// The expansion of a record.
struct LineExpansion<'a, 'f, E> {
    held: &'a mut LineCache,
    /// Which record.
    of: u64,
    find_line: &'a mut FindLine<'f, E>,
    whole: &'a mut String,
}

impl<E> LineExpansion<'_, '_, E> {
    /// Appends what stands from `from` to byte `end` of its line, in full.
    fn expand(
        &mut self,
        line: &str,
        from: LogPosition,
        end: usize,
        depth: usize,
    ) -> Result<(), ReadError<E>> {
        let mut copied = from.at;
        for here in reference_starts(&line[..end], from.at) {
            self.whole.push_str(&line[copied..here]);
            let mut references =
                serde_json::Deserializer::from_str(&line[here..end]).into_iter::<Reference>();
            let Some(Ok(Reference { same_as: Target { record, at, hash } })) = references.next() else {
                return Err(self.refused("has a `sameAs` that is not a record, a byte and a hash"));
            };
            copied = here + references.byte_offset();
            let place = LogPosition { record, at };
            if place >= (LogPosition { record: from.record, at: here }) {
                return Err(self.refused(&format!("refers ahead, to record {record}")));
            }
            if depth == 0 {
                return Err(self.refused(&format!("refers on and on, to record {record} in the end")));
            }
            let lost = format!("refers to a value that record {record} does not hold");
            let Some(held) = self.line(record)? else { return Err(self.refused(&lost)) };
            let Some(held_end) = value_end(&held, at) else { return Err(self.refused(&lost)) };
            if record == from.record && held_end > here {
                return Err(self.refused("refers to what is around it"));
            }
            let start = self.whole.len();
            self.expand(&held, place, held_end, depth - 1)?;
            if self.whole.len() > MAX_RECORD_BYTES {
                return Err(self.refused(&format!("has more than {MAX_RECORD_BYTES} bytes in full")));
            }
            // What is short is never referred to; so no line can make work that is not seen in its length.
            let value = &self.whole[start..];
            if value.len() <= MIN_HELD_BYTES || self::hash(value) != hash {
                return Err(self.refused(&lost));
            }
        }
        self.whole.push_str(&line[copied..end]);
        Ok(())
    }

    fn line(&mut self, record: u64) -> Result<Option<Arc<str>>, ReadError<E>> {
        if let Some(line) = self.held.lines.get(&record) {
            return Ok(Some(Arc::clone(line)));
        }
        let found = (self.find_line)(record).map_err(ReadError::Source)?;
        Ok(found.map(|line| self.held.keep(&line, record)))
    }

    fn refused(&self, why: &str) -> ReadError<E> {
        FileError::Reference(format!("record {} {why}: export the log again", self.of)).into()
    }
}

/// Where the outermost references of a line begin, from byte `at` on, which is not in a string.
fn reference_starts(line: &str, at: usize) -> impl Iterator<Item = usize> {
    let mut scan = Scan::default();
    (at..line.len()).filter(move |&here| {
        let is_mark =
            !scan.in_string && line.as_bytes()[here] == b'{' && line[here..].starts_with(REFERENCE_PREFIX);
        scan.take(line.as_bytes()[here], here);
        is_mark
    })
}

/// Where the object or array that begins at byte `at` of a line ends; `None` where none does.
fn value_end(line: &str, at: usize) -> Option<usize> {
    if !matches!(line.as_bytes().get(at)?, b'{' | b'[') {
        return None;
    }
    let mut scan = Scan::default();
    let mut closed = (at..line.len()).filter_map(|here| scan.take(line.as_bytes()[here], here));
    closed.find(|span| span.start == at).map(|span| span.end)
}

/// The spans of the long objects and arrays of a line, but for the line itself.
fn long_values(line: &str) -> Vec<Range<usize>> {
    let mut scan = Scan::default();
    let closed = line.bytes().enumerate().filter_map(|(at, byte)| scan.take(byte, at));
    closed.filter(|span| span.start > 0 && span.len() > MIN_HELD_BYTES).collect()
}

/// Where in a JSON text a scan is.
#[derive(Default)]
struct Scan {
    in_string: bool,
    escaped: bool,
    /// Where the objects and arrays around this place begin.
    open: Vec<usize>,
}

impl Scan {
    /// Takes in the byte at `at`: the span of the object or array that it closes.
    fn take(&mut self, byte: u8, at: usize) -> Option<Range<usize>> {
        if self.in_string {
            match byte {
                _ if self.escaped => self.escaped = false,
                b'\\' => self.escaped = true,
                b'"' => self.in_string = false,
                _ => {}
            }
            return None;
        }
        match byte {
            b'"' => self.in_string = true,
            b'{' | b'[' => self.open.push(at),
            b'}' | b']' => return self.open.pop().map(|start| start..at + 1),
            _ => {}
        }
        None
    }
}

fn hash(text: &str) -> String {
    format!("{:x}", Sha256::digest(text))
}

//! References to values that a log already holds (SPEC, REC-6).
//!
//! The module works on the text of lines and knows no field but `sameAs`. So it also shortens the values of
//! fields that a later format adds.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::log_line::{FindLine, ReadError, to_line};
use crate::{FileError, MAX_RECORD_BYTES};

/// Number of bytes of JSON above which an object or array occurs only once in a log, and later as a reference.
pub const MIN_HELD_BYTES: usize = 1_024;
/// Maximum depth of references inside referenced values. Each such value is a part of the value that contains it, so
/// the depth never exceeds that of a record's JSON.
const MAX_DEPTH: usize = 16;

/// Start of every reference. It cannot occur inside a string, because there its quotes are escaped.
const REFERENCE_PREFIX: &str = r#"{"sameAs":"#;

/// Position of a value in a log.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct LogPosition {
    /// Sequence number of the record that holds the value.
    pub record: u64,
    /// Index of the value's first byte in the record's line.
    pub at: usize,
}

/// JSON that replaces a value which the log already holds.
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

/// Line of a record in which references replace long values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CompactLine {
    /// Text without the line end.
    pub text: String,
    /// Long values that the log contains for the first time in this line: the hash of the JSON in full, and the byte at
    /// which the value begins in the line.
    pub new_values: Vec<(String, usize)>,
}

/// Replaces long values in the JSON of record `seq`, which has no references, by references.
///
/// `find_position` returns the position of the value with a hash, if the log holds it.
pub fn compact<E>(
    text: &str,
    seq: u64,
    find_position: impl FnMut(&str) -> Result<Option<LogPosition>, E>,
) -> Result<CompactLine, E> {
    let mut spans = long_values(text);
    // Sorts outer values before inner ones.
    spans.sort_by_key(|span| (span.start, std::cmp::Reverse(span.end)));
    let line = CompactLine { text: String::with_capacity(text.len()), new_values: Vec::new() };
    let own = HashMap::new();
    let mut writer = CompactLineWriter { text, seq, find_position, new_positions: own, copied: 0, line };
    let mut written_to = 0;
    for span in spans {
        // False for a value inside one that was replaced.
        if span.start >= written_to {
            written_to = writer.write(span)?;
        }
    }
    writer.copy_to(text.len());
    Ok(writer.line)
}

/// Writer of one line in which references replace long values.
struct CompactLineWriter<'a, F> {
    text: &'a str,
    seq: u64,
    find_position: F,
    /// Byte indices, by hash, of the values that this line holds first.
    new_positions: HashMap<String, usize>,
    /// Byte at which each value begins that the log contains for the first time in this line, by the value's hash.
    copied: usize,
    line: CompactLine,
}

impl<E, F: FnMut(&str) -> Result<Option<LogPosition>, E>> CompactLineWriter<'_, F> {
    /// Writes a reference if the log holds the value, else all text before the value. Returns the number of
    /// bytes of `text` that are written.
    fn write(&mut self, span: Range<usize>) -> Result<usize, E> {
        let hash = hash(&self.text[span.clone()]);
        let own = self.new_positions.get(&hash).map(|&at| LogPosition { record: self.seq, at });
        let position = if own.is_some() { own } else { (self.find_position)(&hash)? };
        self.copy_to(span.start);
        if let Some(LogPosition { record, at }) = position {
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

/// Cache of the lines that later lines may refer to.
#[derive(Clone, Debug, Default)]
pub(crate) struct LineCache {
    lines: HashMap<u64, Arc<str>>,
    bytes: usize,
}

impl LineCache {
    /// Caches the line of record `seq`.
    pub fn keep(&mut self, line: &str, seq: u64) -> Arc<str> {
        let line: Arc<str> = line.into();
        if self.lines.insert(seq, Arc::clone(&line)).is_none() {
            self.bytes += line.len();
        }
        line
    }

    /// Returns the JSON in full of record `seq`, at most [`MAX_RECORD_BYTES`]. Caches its line and those that
    /// it refers to.
    pub fn expand<E>(&mut self, line: &str, seq: u64, find_line: &mut FindLine<E>) -> Result<String, ReadError<E>> {
        let line = self.keep(line, seq);
        let mut whole = String::with_capacity(line.len());
        let mut part = LineExpansion { held: self, of: seq, find_line, whole: &mut whole };
        part.expand(&line, LogPosition { record: seq, at: 0 }, line.len(), MAX_DEPTH)?;
        Ok(whole)
    }

    /// Returns the bytes of the cached lines.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

/// Expansion of one record's line: the replacement of its references by the values.
struct LineExpansion<'a, 'f, E> {
    held: &'a mut LineCache,
    /// Sequence number of the record that is expanded.
    of: u64,
    find_line: &'a mut FindLine<'f, E>,
    whole: &'a mut String,
}

impl<E> LineExpansion<'_, '_, E> {
    /// Appends the text from `from` to byte `end` of its line, in full.
    fn expand(&mut self, line: &str, from: LogPosition, end: usize, depth: usize) -> Result<(), ReadError<E>> {
        let mut copied = from.at;
        for here in reference_starts(&line[..end], from.at) {
            self.whole.push_str(&line[copied..here]);
            let mut references = serde_json::Deserializer::from_str(&line[here..end]).into_iter::<Reference>();
            let Some(Ok(Reference { same_as: Target { record, at, hash } })) = references.next() else {
                return Err(self.refused("has a `sameAs` that is not a record, a byte and a hash"));
            };
            copied = here + references.byte_offset();
            let position = LogPosition { record, at };
            if position >= (LogPosition { record: from.record, at: here }) {
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
            self.expand(&held, position, held_end, depth - 1)?;
            if self.whole.len() > MAX_RECORD_BYTES {
                return Err(self.refused(&format!("has more than {MAX_RECORD_BYTES} bytes in full")));
            }
            // Short values are never referred to. So the work for a line is bounded by its length.
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

/// Returns the byte indices of the outermost references of a line, from byte `at` on. Byte `at` is not in a
/// string.
fn reference_starts(line: &str, at: usize) -> impl Iterator<Item = usize> {
    let mut scan = Scan::default();
    (at..line.len()).filter(move |&here| {
        let is_mark = !scan.in_string && line.as_bytes()[here] == b'{' && line[here..].starts_with(REFERENCE_PREFIX);
        scan.take(line.as_bytes()[here], here);
        is_mark
    })
}

/// Returns the end of the object or array that begins at byte `at` of a line, or `None` if none does.
fn value_end(line: &str, at: usize) -> Option<usize> {
    if !matches!(line.as_bytes().get(at)?, b'{' | b'[') {
        return None;
    }
    let mut scan = Scan::default();
    let mut closed = (at..line.len()).filter_map(|here| scan.take(line.as_bytes()[here], here));
    closed.find(|span| span.start == at).map(|span| span.end)
}

/// Returns the byte ranges of the long objects and arrays of a line, without the line itself.
fn long_values(line: &str) -> Vec<Range<usize>> {
    let mut scan = Scan::default();
    let closed = line.bytes().enumerate().filter_map(|(at, byte)| scan.take(byte, at));
    closed.filter(|span| span.start > 0 && span.len() > MIN_HELD_BYTES).collect()
}

/// State of a scan over JSON text.
#[derive(Default)]
struct Scan {
    in_string: bool,
    escaped: bool,
    /// Byte indices of the starts of the enclosing objects and arrays.
    open: Vec<usize>,
}

impl Scan {
    /// Scans the byte at index `at`. Returns the range of the object or array that it closes.
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
    const_hex::const_encode::<32, false>(&Sha256::digest(text).into()).as_str().into()
}

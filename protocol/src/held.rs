//! Values that a log holds already: written once, referred to afterwards (SPEC, REC-6).
//!
//! All of this works on the text of lines and knows no field but `sameAs`: what is long and comes again is written
//! short, whatever a record will hold one day.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::{FileError, MAX_RECORD_BYTES};

/// Objects and arrays with more bytes of JSON than this are written once.
pub const MIN_HELD_BYTES: usize = 1_024;

/// How a reference begins. Inside a string it cannot stand like that: there its quotes are escaped.
const MARK: &str = r#"{"sameAs":"#;

/// Stands in place of a value that the log holds already.
#[derive(Serialize, Deserialize)]
#[serde(rename_all = "camelCase", deny_unknown_fields)]
struct Reference {
    same_as: Place,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    /// The record whose line has the value in full, this one or an earlier.
    record: u64,
    /// SHA-256 of the value's JSON, 64 hexadecimal digits.
    hash: String,
}

/// A record's line, with references.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CompactLine {
    /// The line, without its end.
    pub text: String,
    /// Hashes of the values that it is the first to have in full.
    pub first_holds: Vec<String>,
}

/// Shortens the JSON of record `seq`, which has no references. `find_record` gives the record whose line has the value
/// of a hash in full, if any does.
pub fn compact<E>(
    text: &str,
    seq: u64,
    find_record: impl FnMut(&str) -> Result<Option<u64>, E>,
) -> Result<CompactLine, E> {
    let mut spans = literals(text);
    // Outer ones first.
    spans.sort_by_key(|span| (span.start, std::cmp::Reverse(span.end)));
    let mut writer = Writer {
        text,
        seq,
        find_record,
        spans,
        next: 0,
        own: HashSet::new(),
        copied: 0,
        line: CompactLine { text: String::with_capacity(text.len()), first_holds: Vec::new() },
    };
    writer.write_values_within(text.len())?;
    writer.line.text.push_str(&text[writer.copied..]);
    Ok(writer.line)
}

/// A line that is being shortened.
struct Writer<'a, F> {
    text: &'a str,
    seq: u64,
    find_record: F,
    spans: Vec<Range<usize>>,
    /// The span to look at next.
    next: usize,
    /// The values that this line has in full so far.
    own: HashSet<String>,
    /// How much of the text is written.
    copied: usize,
    line: CompactLine,
}

impl<E, F: FnMut(&str) -> Result<Option<u64>, E>> Writer<'_, F> {
    /// Replaces what is held among the values that begin before `end`. Returns whether there was any.
    fn write_values_within(&mut self, end: usize) -> Result<bool, E> {
        let mut replaced_any = false;
        while let Some(span) = self.spans.get(self.next).cloned()
            && span.start < end
        {
            self.next += 1;
            let hash = hash(&self.text[span.clone()]);
            let holder = if self.own.contains(&hash) { Some(self.seq) } else { (self.find_record)(&hash)? };
            if let Some(record) = holder {
                let reference = Reference { same_as: Place { record, hash } };
                self.line.text.push_str(&self.text[self.copied..span.start]);
                self.line.text.push_str(&crate::log_file::to_line(&reference));
                self.copied = span.end;
                self.next += self.spans[self.next..].partition_point(|inner| inner.start < span.end);
                replaced_any = true;
            } else if self.write_values_within(span.end)? {
                // It is not in full in this line, and so nothing can refer to it.
                replaced_any = true;
            } else {
                self.own.insert(hash.clone());
                self.line.first_holds.push(hash);
            }
        }
        Ok(replaced_any)
    }
}

/// The long values of the lines that were read, for later ones to refer to.
#[derive(Clone, Debug, Default)]
pub(crate) struct HeldValues {
    by_hash: HashMap<String, Held>,
    bytes: usize,
}

/// A part of a line.
#[derive(Clone, Debug)]
struct Held {
    record: u64,
    line: Arc<str>,
    span: Range<usize>,
}

/// What a line comes to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Expanded {
    /// Its JSON in full.
    Whole(String),
    /// It refers to a record that was not read: read that, then this again.
    Needs(u64),
}

impl HeldValues {
    /// Keeps what the line of record `seq` has in full.
    pub fn learn(&mut self, line: &str, seq: u64) {
        let spans = literals(line);
        if spans.is_empty() {
            return;
        }
        let line: Arc<str> = line.into();
        self.bytes += line.len();
        for span in spans {
            let held = Held { record: seq, line: Arc::clone(&line), span: span.clone() };
            self.by_hash.entry(hash(&line[span])).or_insert(held);
        }
    }

    /// The JSON of record `seq` in full, which has at most [`MAX_RECORD_BYTES`]. The line itself was learned before.
    pub fn expand(&self, line: &str, seq: u64) -> Result<Expanded, FileError> {
        let mut whole = String::with_capacity(line.len());
        let mut copied = 0;
        let mut scan = Scan::default();
        for (at, byte) in line.bytes().enumerate() {
            if at < copied {
                // Within a reference.
                continue;
            }
            if byte == b'{' && !scan.in_string && line[at..].starts_with(MARK) {
                whole.push_str(&line[copied..at]);
                let mut references = serde_json::Deserializer::from_str(&line[at..]).into_iter::<Reference>();
                let Some(Ok(Reference { same_as: Place { record, hash } })) = references.next() else {
                    let sentence = "`sameAs` takes a `record` and a `hash`: export the log again";
                    return Err(FileError::Reference(sentence.into()));
                };
                copied = at + references.byte_offset();
                match self.by_hash.get(&hash).filter(|held| held.record == record) {
                    Some(held) => whole.push_str(&held.line[held.span.clone()]),
                    None if record < seq => return Ok(Expanded::Needs(record)),
                    None => return Err(FileError::lost(seq, record)),
                }
                if whole.len() > MAX_RECORD_BYTES {
                    let sentence = format!("record {seq} has more than {MAX_RECORD_BYTES} bytes in full");
                    return Err(FileError::Reference(sentence));
                }
            } else {
                scan.take(line, at);
            }
        }
        whole.push_str(&line[copied..]);
        Ok(Expanded::Whole(whole))
    }

    /// Whether anything of that record is kept.
    pub fn has_learned(&self, record: u64) -> bool {
        self.by_hash.values().any(|held| held.record == record)
    }

    /// Bytes of the lines that are kept.
    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

/// The spans of the long objects and arrays of a line that have no reference in them, but for the line itself. Inner
/// ones come before those around them.
fn literals(line: &str) -> Vec<Range<usize>> {
    let mut scan = Scan::default();
    let closed = (0..line.len()).filter_map(|at| scan.take(line, at));
    closed.filter(|span| span.start > 0 && span.len() > MIN_HELD_BYTES).collect()
}

/// Where in a JSON text a scan is.
#[derive(Default)]
struct Scan {
    in_string: bool,
    escaped: bool,
    /// Where the objects and arrays around this place begin, and whether there is a reference in them.
    open: Vec<(usize, bool)>,
}

impl Scan {
    /// Takes in the byte at `at`: the span of the object or array that it closes, if there is no reference in it.
    fn take(&mut self, text: &str, at: usize) -> Option<Range<usize>> {
        let byte = text.as_bytes()[at];
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
            b'{' => self.open.push((at, text[at..].starts_with(MARK))),
            b'[' => self.open.push((at, false)),
            b'}' | b']' => {
                let (start, has_reference) = self.open.pop()?;
                if has_reference && let Some(around) = self.open.last_mut() {
                    around.1 = true;
                }
                return (!has_reference).then_some(start..at + 1);
            }
            _ => {}
        }
        None
    }
}

fn hash(text: &str) -> String {
    format!("{:x}", Sha256::digest(text))
}

//! Lines of a log: serialization, and errors of reading.

use serde::Serialize;

use crate::FileError;

/// Function that returns the line of an earlier record, by its sequence number.
pub type FindLine<'a, E> = dyn FnMut(u64) -> Result<Option<String>, E> + 'a;

/// Error of reading a line.
#[derive(Debug)]
pub enum ReadError<E> {
    /// The line is not a record, or a reference in it cannot be resolved.
    Line(FileError),
    /// An earlier line could not be read.
    Source(E),
}

impl<E> From<FileError> for ReadError<E> {
    fn from(reason: FileError) -> Self {
        Self::Line(reason)
    }
}

pub(crate) fn to_line(value: &impl Serialize) -> String {
    serde_json::to_string(value).expect("plain data with string keys")
}

//! Lines of a log: how they are written, and why one is not read.

use serde::Serialize;

use crate::FileError;

/// Gives the lines of earlier records.
pub type FindLine<'a, E> = dyn FnMut(u64) -> Result<Option<String>, E> + 'a;

/// Why a line is not read.
#[derive(Debug)]
pub enum ReadError<E> {
    /// It is no record, or refers to what is not there.
    Line(FileError),
    /// An earlier line could not be had.
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

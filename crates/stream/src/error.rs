//! Errors of encoding and of frame headers.

use thiserror::Error;

/// Reason for which pixels were not encoded or bytes are not a frame. Each message says what to change.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum StreamError {
    /// The number of bytes does not fit the size.
    #[error("a picture of {width}x{height} has {expected} bytes, not {found}: pass 4 bytes for each pixel")]
    PixelCount { width: u16, height: u16, expected: usize, found: usize },
    #[error("a picture of {width}x{height} has no pixels: give it a width and a height")]
    Empty { width: u16, height: u16 },
    /// The quality is not from 1 to 100.
    #[error("{0} is no JPEG quality: choose one from 1 to 100")]
    JpegQuality(u8),
    /// The library of the codec failed.
    #[error("the picture cannot be encoded ({0}): try a smaller one")]
    Encode(String),
    /// The message is shorter than a header. Its bytes.
    #[error(
        "a frame begins with {header} bytes of header, but the message has {0}: send it whole",
        header = crate::HEADER_BYTES
    )]
    Short(usize),
    /// A header field has a value that this version does not know.
    #[error("the frame's {field} is {value}, which version 1 of the protocol does not have: update this program")]
    Unknown { field: &'static str, value: u32 },
}

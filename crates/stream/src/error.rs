//! Why pixels or bytes are no frame.

use thiserror::Error;

/// Why pixels were not encoded, or bytes are not a frame. Each sentence says what to change.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum StreamError {
    /// The pixels are not as many as the size says.
    #[error("a picture of {width}x{height} has {expected} bytes, not {found}: pass 4 bytes for each pixel")]
    PixelCount {
        /// Pixels.
        width: u16,
        /// Pixels.
        height: u16,
        /// Bytes there should be.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// There is nothing to encode.
    #[error("a picture of {width}x{height} has no pixels: give it a width and a height")]
    Empty {
        /// Pixels.
        width: u16,
        /// Pixels.
        height: u16,
    },
    /// A quality that JPEG does not know.
    #[error("{0} is no JPEG quality: choose one from 1 to 100")]
    JpegQuality(u8),
    /// The codec's library refused.
    #[error("the picture cannot be encoded ({0}): try a smaller one")]
    Encode(String),
    /// A message too short to be a frame.
    #[error(
        "a frame begins with {header} bytes of header, but the message has {0}: send it whole",
        header = crate::HEADER_BYTES
    )]
    Short(usize),
    /// A header with a value that this version does not know.
    #[error(
        "the frame's {field} is {value}, which version 1 of the protocol does not have: update this program"
    )]
    Unknown {
        /// Which field.
        field: &'static str,
        /// What it holds.
        value: u32,
    },
}

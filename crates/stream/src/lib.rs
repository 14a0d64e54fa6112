//! Frames of a picture stream: encoding, division into tiles, headers and pacing.
//!
//! - [`jpeg()`] and [`png()`] encode pixels.
//! - [`changed_tiles()`] finds the parts of a picture that differ, and [`png_bands()`] cuts a lossless picture into
//!   bands.
//! - [`FrameHeader`] is the header before the payload on the wire.
//! - [`FramePacer`] decides the next frame of one client.
//!
//! The crate knows no sockets, no scene and no clock: callers pass times in. Begin with [`FramePacer`], then
//! [`changed_tiles()`] and [`FrameHeader`].

mod encode;
mod error;
mod frame;
mod pace;
mod tiles;

pub use encode::{MOVING_QUALITY, jpeg, png};
pub use error::StreamError;
pub use frame::{Codec, FrameFlags, FrameHeader, FrameTile, HEADER_BYTES};
pub use pace::{FramePacer, FrameQuality, MAX_FRAMES_IN_FLIGHT, NextFrame, SETTLE_AFTER, ViewContent};
pub use tiles::{changed_tiles, crop, png_bands, whole_tile};

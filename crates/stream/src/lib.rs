//! Pixels to frames, and when a client gets its next one.
//!
//! [`jpeg()`] and [`png()`] encode, [`changed_tiles()`] and [`png_bands()`] say in which parts, [`FrameHeader`] is what stands before the payload on the wire, [`FramePacer`]
//! decides for one client what it needs next. No sockets, no scene and no clock: times are passed in.

mod encode;
mod error;
mod frame;
mod pace;
mod tiles;
mod window;

pub use encode::{MOVING_QUALITY, jpeg, png};
pub use error::StreamError;
pub use frame::{Codec, FrameFlags, FrameHeader, FrameTile, HEADER_BYTES};
pub use pace::{FramePacer, FrameQuality, NextFrame, SETTLE_AFTER, ViewContent};
pub use tiles::{changed_tiles, crop, png_bands, whole_tile};
pub use window::{AckWindow, MAX_FRAMES_IN_FLIGHT};

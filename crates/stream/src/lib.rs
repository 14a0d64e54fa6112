//! Pixels to frames, and when a client gets its next one.
//!
//! [`jpeg()`] and [`png()`] encode, [`changed()`] and [`png_bands()`] say in which parts, [`FrameHeader`] is what stands before the payload on the wire, [`Pace`]
//! decides for one client what it needs next. No sockets, no scene and no clock: times are passed in.

mod encode;
mod error;
mod frame;
mod pace;
mod tiles;
mod window;

pub use encode::{MOVING_QUALITY, jpeg, png};
pub use error::StreamError;
pub use frame::{Codec, Flags, FrameHeader, HEADER_BYTES, Tile};
pub use pace::{Content, Next, Pace, Quality, SETTLE_AFTER};
pub use tiles::{changed, cut, png_bands, whole};
pub use window::{AckWindow, WINDOW};

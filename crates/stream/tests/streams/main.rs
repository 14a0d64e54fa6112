//! Frames: headers, encoders, tiles and pacing.

mod encode;
mod frame;
mod pace;
mod tiles;

//! Relighting on processors: shadow maps and what each light adds to what pixels see, in vectorised Rust on all cores.
//!
//! The second way to make moving pictures, for machines where the graphics device is a software driver. It starts from
//! a G-buffer that [`Surfaces`] is made of, and knows neither devices nor scenes: whoever calls it brings triangles, a
//! light's numbers and the memory that results go to.
#![forbid(unsafe_code)]
#![expect(
    clippy::inline_always,
    reason = "vectors are only made of what is inlined where the processor was chosen"
)]

mod depth_map;
mod elementary;
mod lanes;
mod simd;
mod workers;

pub use depth_map::DepthMap;
pub use lanes::{F32s, Masks, U32s, Vec3s};
pub use workers::Workers;

//! Tests that pictures shaded by the CPU equal those of the GPU. All tests are in one binary, so that all comparisons
//! share one renderer per backend.
//!
//! Each finds what pixels show by itself and draws its own maps. docs/decisions/37-reference-renderer.md lists the code
//! and data that they share, and so the faults that these tests cannot detect.

mod aovs;
mod bent;
pub mod both;
mod driver;
mod straight;
mod threads;

//! The harness behind `bendylights bench`: a server of its own, a client that behaves as the page does, and what they
//! measure.
//!
//! The tests of whole sessions drive the server with the same client.

#![expect(clippy::disallowed_methods, reason = "measurements hold within bounds, not to the bit")]

mod bent;
mod cases;
mod chart;
mod circle;
mod client;
pub mod compare;
pub mod drag;
mod dragged;
mod error;
pub mod frame;
pub mod log;
pub mod neighbours;
mod peers;
mod process;
mod progress;
mod quantiles;
pub mod session;
pub mod shadow;
mod solids;
pub mod solver;
pub mod stills;
pub mod sweep;

pub use cases::SessionCase;
pub use client::{Client, Incoming, KnownHistory, Tiles};
pub use error::BenchError;
pub use peers::Peers;
pub use process::{Response, ServerAddress, ServerProcess};
pub use progress::Progress;
pub use quantiles::Quantiles;

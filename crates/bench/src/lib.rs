//! Benchmarks behind `bendylights bench`, and the comparison of pictures with the reference.
//!
//! A benchmark of the server starts `bendylights serve` as a process of its own and drives it with a client that
//! behaves as the page does. A benchmark of the renderer draws in this process. Each returns a report to serialize, and
//! most also return a chart in SVG.
//!
//! The crate knows no command line: the commands of `bendylights bench` parse options and write files. It knows nothing
//! of the server's internals and uses its HTTP and WebSocket interface only. The session tests of the workspace drive
//! the server with the same client.
//!
//! Begin with `ServerProcess` and `Client` for benchmarks of the server, `frame` for benchmarks of the renderer, and
//! `compare` for pictures against the reference.

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
pub mod isolation;
pub mod log;
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

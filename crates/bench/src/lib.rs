//! The harness behind `bendylights bench`: a server of its own, a client that behaves as the page does, and what they
//! measure.
//!
//! The tests of whole sessions drive the server with the same client.

mod client;
mod error;
mod process;
pub mod session;

pub use client::{Client, Incoming, Known};
pub use error::BenchError;
pub use process::{Address, Response, ServerProcess};

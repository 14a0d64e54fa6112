//! The harness behind `bendylights bench`: a server of its own, a client that behaves as the page does, and what they
//! measure.
//!
//! The tests of whole sessions drive the server with the same client.

mod client;
pub mod compare;
pub mod direction;
mod error;
mod process;
pub mod session;
pub mod shadow;
pub mod solver;
pub mod stills;
pub mod stress;
mod timing;

pub use client::{Client, Incoming, Known};
pub use error::BenchError;
pub use process::{Address, Response, ServerProcess};

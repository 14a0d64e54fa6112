//! The server: sessions over WebSocket and HTTP, as `protocol/SPEC.md` says.
//!
//! Each session is a task with an inbox (`room`), each connection two (`socket`). One thread owns the graphics device
//! (`renderer`), one writes to the store (`storage`). What blocks or computes for long runs on the blocking pool.

mod ask;
mod backend;
mod connections;
mod error;
mod hosts;
mod http;
mod lane;
mod limits;
mod metrics;
mod private;
mod renderer;
mod room;
mod scenes;
mod server;
mod socket;
mod storage;
mod token;

pub use error::ServerError;
pub use hosts::PublicUrl;
pub use server::{Config, Server};
pub use token::Token;

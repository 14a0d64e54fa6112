//! The server: sessions over WebSocket and HTTP, as `protocol/SPEC.md` says.
//!
//! Each session is a task with an inbox (`room`), each connection two (`socket`). One thread owns the graphics device
//! (`renderer`), one writes to the store (`storage`). What blocks or computes for long runs on the blocking pool.

mod access;
mod allowances;
mod anonymous;
mod backend;
mod background;
mod charges;
mod connections;
mod data_folder;
mod document_text;
mod error;
mod first_session;
mod http;
mod in_flight;
mod limits;
mod metrics;
mod outbox;
mod outboxes;
mod pacing;
mod permits;
mod picture_stats;
mod probe;
#[cfg(target_os = "linux")]
mod process_metrics;
mod renderer;
mod request;
mod room;
mod scenes;
mod send_within;
mod server;
mod socket;
mod solver;
mod state;
mod storage;
mod trace;
mod views;

pub use access::{PublicUrl, Token};
pub use background::request_runtime;
pub use error::ServerError;
pub use first_session::StartSession;
pub use server::{Server, ServerConfig};

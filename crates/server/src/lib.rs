//! The server of sessions over WebSocket and HTTP, as `protocol/SPEC.md` specifies.
//!
//! - Each session is a task with an inbox (`room`). Each WebSocket connection has two tasks (`socket`).
//! - One thread owns the graphics device (`renderer`), and one writes to the store (`storage`).
//! - Blocking and long work runs on the blocking pool, on background threads (`background`) or on solver threads
//!   (`solver`).
//!
//! The crate shapes no JSON: `protocol` converts between JSON and domain types. It knows no light model, no edit rules
//! and no rendering of its own. Begin with [`Server`], then `socket`, `room` and `renderer`.

mod access;
mod allowances;
mod anonymous;
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
mod server;
mod services;
mod socket;
mod solver;
mod state;
mod storage;
mod trace;
mod views;
mod write_timeout;

pub use access::{PublicUrl, Token};
pub use background::request_runtime;
pub use error::ServerError;
pub use first_session::StartSession;
pub use server::{Server, ServerConfig};

//! Where edit logs and assets live: a folder with one SQLite database, a file for each asset and one for its name.
//!
//! What [`Store::append`] and [`Store::put_asset`] have returned from survives a crash of the program and of the
//! machine. A log is read in passes and never held in memory as a whole. Calls block; whoever serves many runs them on
//! a thread for that.

mod assets;
mod checkpoints;
mod database;
#[cfg(test)]
mod durability;
mod error;
mod log_file;
mod operations;
mod records;
mod sessions;

pub use assets::{MAX_ASSET_BYTES, check_scene_name};
pub use checkpoints::{Opened, Tail};
pub use database::{DATABASE, FILES, Store};
pub use error::StoreError;
pub use log_file::{ReplayedLog, replay_log};
pub use operations::{MAX_REJECTIONS, Outcome, Rejection};
pub use protocol::MAX_RECORD_BYTES;
pub use records::{Batch, MAX_PAGE_BYTES};
pub use sessions::{MAX_NAME_CHARS, MAX_SESSIONS, SessionRow};

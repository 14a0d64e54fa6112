//! Storage of edit logs and assets in one folder: a SQLite database, one file per asset, and one for its name.
//!
//! Everything that [`Store::append`] or [`Assets::put`] has confirmed survives a crash of the program and of the
//! machine. A log is read record by record and never held in memory as a whole. Calls block, so a server runs them on a
//! thread of its own.
//!
//! The crate knows no async runtime, no socket and no rendering. All SQL is in `sqlite`, which stores lines, numbers
//! and hashes and does not know their meaning. Begin with [`Store`], then the modules `records`, `log_file` and
//! `sqlite`.

mod assets;
mod backup;
mod checkpoints;
mod difference;
mod disk;
mod error;
mod limits;
mod log_file;
mod operations;
mod records;
mod session_list;
mod sessions;
mod sqlite;
mod store;
mod stored;

pub use assets::{Assets, check_folder, check_scene_name};
pub use backup::{Backup, back_up};
pub use checkpoints::OpenedSession;
pub use difference::{Difference, DifferingPart};
pub use error::StoreError;
pub use limits::{MAX_ASSET_BYTES, MAX_NAME_CHARS, MAX_PAGE_BYTES, MAX_REJECTIONS, MAX_SESSIONS};
pub use log_file::{ReplayedLog, check_log, replay_log, visit_log};
pub use protocol::MAX_RECORD_BYTES;
pub use records::{CommitBatch, RecordTail};
pub use sqlite::DATABASE_FILE;
pub use store::{FILES, Store};
pub use stored::{LastChange, Rejection, SessionChange, SessionRow, SessionSummary};

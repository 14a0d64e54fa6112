//! Where edit logs and assets live: a folder with one SQLite database, a file for each asset and one for its name.
//!
//! What [`Store::append`] and [`Assets::put`] have returned from survives a crash of the program and of the
//! machine. A log is read in passes and never held in memory as a whole. Calls block; whoever serves many runs them on
//! a thread for that.
//!
//! Logs are made, read and replayed here as lines and records; `sqlite` keeps them, and knows nothing of what they mean.

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
pub use session_list::SessionChange;
pub use sqlite::DATABASE_FILE;
pub use store::{FILES, Store};
pub use stored::{LastChange, Rejection, SessionRow, SessionSummary};

//! Edit sessions: the log of records, undo and redo, gestures, replay.
//!
//! A [`Session`] is a document with its history and the gestures in progress. It is a function of its records: the same
//! records give the same session. The crate does no IO and knows no clock, no network and no geometry. The owner of a
//! session (a room of the server) stores the records, gives the time and finds scenes.
//!
//! Begin with [`Session`] and [`Record`], then `history.rs` (steps that undo can revert), `undo.rs` and `gesture.rs`.

mod gesture;
mod history;
mod record;
mod refusal;
mod session;
mod undo;

pub use gesture::{Gesture, LEASE_MS, MAX_GESTURES};
pub use history::{MAX_UNDO_DEPTH, PastUndo};
pub use record::{Action, Actor, Record, RecordedCommand, UndoScope};
pub use refusal::{EditRefusal, ReplayError};
pub use session::{EditRequest, EditSources, GroupedEdit, MAX_RECORDS, Session, SessionHistory};
pub use undo::{FindRecord, MAX_STEPS_PASSED_OVER, Reverted};

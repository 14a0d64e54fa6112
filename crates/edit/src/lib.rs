//! The edit log: records, undo and redo, gestures, replay.
//!
//! A [`Session`] is a document, how it came about and what is being dragged in it. It is a function of its
//! records: whoever feeds it the same ones has the same session. It does no IO and knows no clock; whoever owns
//! it writes records down, tells the time and finds scenes.

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

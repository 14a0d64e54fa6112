//! Refusals of requests, and errors of replay.

use document::EditError;
use thiserror::Error;

/// Reason why a request is refused. The message says what to do.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EditRefusal {
    /// Refusal by the document.
    #[error("{0}")]
    Edit(#[from] EditError),
    /// Light that another actor drags.
    #[error("{light} is held by {holder}, who is dragging it: wait until it is let go")]
    Locked {
        /// Light by its [`Document::light_name`](document::Document::light_name).
        light: String,
        /// Name of the actor who drags the light.
        holder: String,
    },
    /// Control points that were renumbered after the latest record that the sender knew.
    #[error("the control points of {light} were renumbered in record {seq}: look at the light again")]
    Stale {
        /// Light by its [`Document::light_name`](document::Document::light_name).
        light: String,
        /// Number of the record that renumbered the control points.
        seq: u64,
    },
    /// Undo, although there is no step of which anything can be undone.
    #[error("there is nothing to undo{}", but(passed.as_deref()))]
    NothingToUndo {
        /// Reason why the latest step was passed over, if there is a step.
        passed: Option<String>,
    },
    /// Redo, although there is no undo of which anything can be redone.
    #[error("there is nothing to redo{}", but(passed.as_deref()))]
    NothingToRedo {
        /// Reason why the latest undo was passed over, if there is an undo.
        passed: Option<String>,
    },
    /// Undo or redo of a step whose record cannot be found.
    #[error("record {0} cannot be read, and so not be taken back: replay the log to see what is wrong with it")]
    MissingRecord(u64),
    /// Gesture that was never begun, has ended, or belongs to another actor.
    #[error("there is no gesture {0} of yours: begin it again")]
    NoGesture(String),
    /// Commit of a gesture that has had no update.
    #[error("gesture {0} was never updated and has nothing to commit: cancel such a gesture")]
    EmptyGesture(String),
    /// Begin of a gesture with the name of one in progress.
    #[error("gesture {0} is already under way: choose another name")]
    GestureExists(String),
    /// Command of a gesture that changes another light than the gesture's. The field is the name of the gesture's
    /// light.
    #[error("a gesture on {0} can only change that light: begin another gesture")]
    OtherLight(String),
    /// Refused command of a group, which refuses the group.
    #[error("edit {number} of the group: {reason}; nothing of the group was done")]
    InGroup {
        /// Position in the group, counted from 1.
        number: usize,
        /// Reason for that command.
        reason: Box<Self>,
    },
    /// Too many gestures or records in the session.
    #[error("a session has at most {limit} {what}: {remedy}")]
    TooMany {
        what: &'static str,
        limit: usize,
        /// Advice, as a clause.
        remedy: &'static str,
    },
}

impl EditRefusal {
    /// Makes the refusal of a group from that of its command at `index`.
    pub fn in_group(index: usize, reason: Self) -> Self {
        Self::InGroup { number: index + 1, reason: Box::new(reason) }
    }
}

fn but(passed: Option<&str>) -> String {
    passed.map_or_else(String::new, |why| format!(": {why}"))
}

/// Reason why a record does not continue a log.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReplayError {
    /// Record that is missing or out of order.
    #[error("record {found} follows record {after}: the log has a gap; export it again")]
    Gap {
        /// Sequence of the record.
        found: u64,
        /// Sequence of the record before.
        after: u64,
    },
    /// Record that does not fit the document before it.
    #[error("record {seq}: {reason}")]
    Record { seq: u64, reason: EditError },
    /// Undo or redo of a record that is not in effect.
    #[error("record {seq} takes back record {target}, which is not in effect: the log was changed by hand")]
    TargetNotInEffect {
        seq: u64,
        /// Record to undo or redo.
        target: u64,
    },
}

//! Why a request is refused, and why a log cannot be replayed.

use document::EditError;
use thiserror::Error;

/// Why a request is refused. Each sentence says what to do.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum EditRefusal {
    /// The document does not allow it.
    #[error("{0}")]
    Edit(#[from] EditError),
    /// The light is being dragged.
    #[error("{light} is held by {holder}, who is dragging it: wait until it is let go")]
    Locked {
        /// Which, as [`Document::light_name`](document::Document::light_name) says it.
        light: String,
        /// Name of whoever drags it.
        holder: String,
    },
    /// The control points have other numbers than the sender knew.
    #[error("the control points of {light} were renumbered in record {seq}: look at the light again")]
    Stale {
        /// Which, as [`Document::light_name`](document::Document::light_name) says it.
        light: String,
        /// The record that did it.
        seq: u64,
    },
    /// No step of which anything is left to take back.
    #[error("there is nothing to undo{}", but(passed.as_deref()))]
    NothingToUndo {
        /// Why the latest step stays, where there is one.
        passed: Option<String>,
    },
    /// No undo of which anything is left to take back.
    #[error("there is nothing to redo{}", but(passed.as_deref()))]
    NothingToRedo {
        /// Why the latest undo stays, where there is one.
        passed: Option<String>,
    },
    /// A step whose record its owner does not find.
    #[error(
        "record {0} cannot be read, and so not be taken back: replay the log to see what is wrong with it"
    )]
    MissingRecord(u64),
    /// No such drag: never begun, ended, or somebody else's.
    #[error("there is no gesture {0} of yours: begin it again")]
    NoGesture(String),
    /// A drag that is committed before its first update.
    #[error("gesture {0} was never updated and has nothing to commit: cancel such a gesture")]
    EmptyGesture(String),
    /// A drag of that name is under way.
    #[error("gesture {0} is already under way: choose another name")]
    GestureExists(String),
    /// A drag's command is not of its light.
    #[error("a gesture on {0} can only change that light: begin another gesture")]
    OtherLight(String),
    /// A command of a group is refused, and so is the group.
    #[error("edit {number} of the group: {reason}; nothing of the group was done")]
    InGroup {
        /// Which, counted from 1.
        number: usize,
        /// What stands in that one's way.
        reason: Box<Self>,
    },
    /// A limit of the session.
    #[error("a session has at most {limit} {what}: {remedy}")]
    TooMany {
        /// Of what.
        what: &'static str,
        /// How many.
        limit: usize,
        /// What to do.
        remedy: &'static str,
    },
}

impl EditRefusal {
    /// Why a group is refused: for its command of that index.
    pub fn in_group(index: usize, reason: Self) -> Self {
        Self::InGroup { number: index + 1, reason: Box::new(reason) }
    }
}

fn but(passed: Option<&str>) -> String {
    passed.map_or_else(String::new, |why| format!(": {why}"))
}

/// Why a record does not go on from where a log stands.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReplayError {
    /// A record is missing or out of order.
    #[error("record {found} follows record {after}: the log has a gap; export it again")]
    Gap {
        /// The sequence that came.
        found: u64,
        /// The one before.
        after: u64,
    },
    /// A record does not fit the document before it.
    #[error("record {seq}: {reason}")]
    Record {
        /// Which.
        seq: u64,
        /// Why.
        reason: EditError,
    },
    /// A record takes back what is not there to take back.
    #[error("record {seq} takes back record {target}, which is not in effect: the log was changed by hand")]
    TargetNotInEffect {
        /// Which.
        seq: u64,
        /// What it takes back.
        target: u64,
    },
}

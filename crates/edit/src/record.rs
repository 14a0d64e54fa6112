//! Records of the log.

use document::{Change, Command, DragOutcome};

/// Person or program that makes an edit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Actor {
    /// Identifies the actor across connections. Undo of one's own steps compares it.
    pub id: String,
    /// Name for people.
    pub name: String,
}

/// Scope of the steps that undo and redo consider.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UndoScope {
    /// Steps of the actor.
    Mine,
    /// Steps of all actors.
    Session,
}

/// Committed step.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Sequence number, from 1 without gaps.
    pub seq: u64,
    /// Time in milliseconds since 1970 UTC, for people. Nothing depends on it.
    pub time_ms: u64,
    pub actor: Actor,
    /// Sender's name for the operation, unique for that actor. An operation with a known name is not executed again.
    pub op_id: String,
    /// Requested action.
    pub action: Action,
    /// Changes that it made. Replay applies these and ignores the rest.
    pub changes: Vec<Change>,
}

/// Requested action of a record.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    Edit {
        /// Command as the client sent it.
        command: Command,
        /// True if another actor had changed the same light after the latest record that the sender knew.
        rebased: bool,
        /// Outcome, if the command drags a feature.
        outcome: Option<Box<DragOutcome>>,
    },
    /// Last command of a gesture.
    Gesture {
        /// Command as the client sent it.
        command: Command,
        /// True as in `Edit`, for changes after the latest record that the client knew when the gesture began.
        rebased: bool,
        /// Outcome, if the command drags a feature.
        outcome: Option<Box<DragOutcome>>,
    },
    /// Several commands as one step.
    Group {
        /// Commands of the step, in order.
        edits: Vec<RecordedCommand>,
        /// True as in `Edit`, for any of the commands.
        rebased: bool,
    },
    /// Undo of a step.
    Undo {
        /// Scope of the steps among which the target was searched.
        scope: UndoScope,
        /// Sequence of the step's record.
        target: u64,
        /// Changes that were not reverted, with the reasons.
        skipped: Vec<String>,
    },
    /// Redo of an undone step.
    Redo {
        /// Scope of the undos among which the target was searched.
        scope: UndoScope,
        /// Sequence of the undo's record.
        target: u64,
        /// Changes that were not restored, with the reasons.
        skipped: Vec<String>,
    },
}

/// Command of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedCommand {
    /// Command as the client sent it, with ids in place of names.
    pub command: Command,
    /// Outcome, if the command drags a feature.
    pub outcome: Option<Box<DragOutcome>>,
}

impl Action {
    /// Returns the changes that an undo or redo did not revert, with the reasons; empty for other actions.
    pub fn skipped(&self) -> &[String] {
        match self {
            Self::Edit { .. } | Self::Gesture { .. } | Self::Group { .. } => &[],
            Self::Undo { skipped, .. } | Self::Redo { skipped, .. } => skipped,
        }
    }

    /// Returns the commands, each with its outcome if it drags a feature; empty for undo and redo.
    pub fn commands(&self) -> Vec<(&Command, Option<&DragOutcome>)> {
        match self {
            Self::Edit { command, outcome, .. } | Self::Gesture { command, outcome, .. } => {
                vec![(command, outcome.as_deref())]
            }
            Self::Group { edits, .. } => edits.iter().map(|edit| (&edit.command, edit.outcome.as_deref())).collect(),
            Self::Undo { .. } | Self::Redo { .. } => Vec::new(),
        }
    }

    /// Returns true if another actor had changed the same light since the record that the sender knew.
    pub fn rebased(&self) -> bool {
        match self {
            Self::Edit { rebased, .. } | Self::Gesture { rebased, .. } | Self::Group { rebased, .. } => *rebased,
            Self::Undo { .. } | Self::Redo { .. } => false,
        }
    }
}

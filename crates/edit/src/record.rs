//! What the log holds.

use document::{Change, Command, DragOutcome};

/// Who did it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Actor {
    /// Stays with a person over connections; decides what "mine" means in undo.
    pub id: String,
    /// For people.
    pub name: String,
}

/// Whose steps undo and redo look at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UndoScope {
    /// One's own.
    Mine,
    /// Everybody's.
    Session,
}

/// One committed step.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Counts from 1 without gaps.
    pub seq: u64,
    /// When, in milliseconds since 1970 UTC. For people; nothing depends on it.
    pub time_ms: u64,
    /// Who.
    pub actor: Actor,
    /// The sender's own name for the step, unique among that actor's: one that comes again is not carried out again.
    pub op_id: String,
    /// What was asked for.
    pub action: Action,
    /// What it did. Replay makes these and looks at nothing else.
    pub changes: Vec<Change>,
}

/// What was asked for.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// A command.
    Edit {
        /// As it was sent.
        command: Command,
        /// Whether somebody else had changed the same light after the latest record that the sender knew.
        rebased: bool,
        /// How it ended where it drags a feature.
        outcome: Option<Box<DragOutcome>>,
    },
    /// The last command of a drag.
    Gesture {
        /// As it was sent.
        command: Command,
        /// As of an edit, from the record that the holder knew when the drag began.
        rebased: bool,
        /// As of an edit.
        outcome: Option<Box<DragOutcome>>,
    },
    /// Commands as one step.
    Group {
        /// In order.
        edits: Vec<RecordedCommand>,
        /// As of an edit, of any of them.
        rebased: bool,
    },
    /// Taking back a step.
    Undo {
        /// Whose steps were looked at.
        scope: UndoScope,
        /// The step's record.
        target: u64,
        /// What was left as it is, and why.
        skipped: Vec<String>,
    },
    /// Taking back an undo.
    Redo {
        /// Whose undos were looked at.
        scope: UndoScope,
        /// The undo's record.
        target: u64,
        /// What was left as it is, and why.
        skipped: Vec<String>,
    },
}

/// A command of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedCommand {
    /// As it was sent, with ids for names.
    pub command: Command,
    /// How it ended where it drags a feature.
    pub outcome: Option<Box<DragOutcome>>,
}

impl Action {
    /// What undo or redo left as it was.
    pub fn skipped(&self) -> &[String] {
        match self {
            Self::Edit { .. } | Self::Gesture { .. } | Self::Group { .. } => &[],
            Self::Undo { skipped, .. } | Self::Redo { skipped, .. } => skipped,
        }
    }

    /// The commands, and how each ended that drags a feature; none of undo and redo.
    pub fn commands(&self) -> Vec<(&Command, Option<&DragOutcome>)> {
        match self {
            Self::Edit { command, outcome, .. } | Self::Gesture { command, outcome, .. } => {
                vec![(command, outcome.as_deref())]
            }
            Self::Group { edits, .. } => {
                edits.iter().map(|edit| (&edit.command, edit.outcome.as_deref())).collect()
            }
            Self::Undo { .. } | Self::Redo { .. } => Vec::new(),
        }
    }

    /// Whether somebody else came in between.
    pub fn rebased(&self) -> bool {
        match self {
            Self::Edit { rebased, .. } | Self::Gesture { rebased, .. } | Self::Group { rebased, .. } => {
                *rebased
            }
            Self::Undo { .. } | Self::Redo { .. } => false,
        }
    }
}

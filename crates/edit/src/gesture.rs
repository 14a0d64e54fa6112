//! Gestures: drags in progress. Everybody sees them, no log has them, and each locks one light for other actors.

use document::{
    Change, Command, CommandContext, CommandResult, Document, DragOutcome, EditError, NumberedLight, execute_command,
};
use light::LightId;

use crate::{Actor, EditRefusal};

/// Time in milliseconds after which a gesture without an update expires.
pub const LEASE_MS: u64 = 30_000;
/// Maximum number of gestures of a session at one time.
pub const MAX_GESTURES: usize = 64;

/// Drag in progress.
#[derive(Clone, Debug, PartialEq)]
pub struct Gesture {
    /// Name that the client chose for the gesture.
    pub id: String,
    /// Connection of the client that drags. The gesture ends with it.
    pub client: u64,
    /// Holder.
    pub actor: Actor,
    pub light: LightId,
    /// Number that the client gave its latest valid update; 0 before the first.
    pub update: u64,
    /// Latest valid command.
    pub command: Option<Command>,
    /// Refusal of the latest update; `None` if it was valid.
    pub refusal: Option<EditRefusal>,
    /// State of the light in the drag, as all clients see it.
    pub live: Option<LiveLight>,
    /// Latest record that the client knew when the gesture began. Indices of control points refer to the numbering
    /// after that record.
    pub(crate) base_seq: u64,
    /// Time of the latest update, on a clock of the session's owner.
    pub(crate) updated_at_ms: u64,
}

/// State of a light in a drag. It is computed once for each update, and shared by all its readers.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveLight {
    /// Changes that a commit of the gesture would make in the document.
    pub changes: Vec<Change>,
    /// Outcome of the latest update, if it drags a feature.
    pub outcome: Option<DragOutcome>,
    /// Light in the document, without the drag.
    pub(crate) before: NumberedLight,
    /// Light with the changes of the drag.
    pub(crate) after: NumberedLight,
    /// Lights that the drag adds.
    pub(crate) added: Vec<NumberedLight>,
}

impl LiveLight {
    /// Computes the result of `command` for `light`, which the command changes and does not remove.
    pub(crate) fn of(
        light: LightId,
        document: &Document,
        command: &Command,
        context: CommandContext,
    ) -> Result<Self, EditRefusal> {
        let CommandResult { changes, document: after, outcome } = execute_command(document, command, context)?;
        let placed = |document: &Document| {
            let placed = document.lights().get(&light).cloned();
            placed.ok_or(EditRefusal::Edit(EditError::NoLight(light)))
        };
        let added = changes.iter().filter_map(|change| match change {
            Change::Light { old: None, new: Some(added), .. } => Some(added.clone()),
            _ => None,
        });
        let (added, before) = (added.collect(), placed(document)?);
        Ok(Self { changes, outcome, before, after: placed(&after)?, added })
    }
}

impl Gesture {
    /// Changes that a commit would make in the document.
    pub fn changes(&self) -> &[Change] {
        self.live.as_ref().map_or(&[], |shown| &shown.changes)
    }
}

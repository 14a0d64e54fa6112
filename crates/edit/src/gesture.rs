//! Drags under way: live for everybody, in no log, and a soft lock on one light each.

use document::{
    Change, Command, CommandContext, CommandResult, Document, DragOutcome, EditError, NumberedLight,
    execute_command,
};
use light::LightId;

use crate::{Actor, EditRefusal};

/// How long a gesture is held without an update, in milliseconds.
pub const LEASE_MS: u64 = 30_000;
/// Gestures that a session has under way at most.
pub const MAX_GESTURES: usize = 64;

/// One drag under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Gesture {
    /// Its holder's name for it.
    pub id: String,
    /// The connection that holds it; the gesture ends with it.
    pub client: u64,
    /// Who holds it.
    pub actor: Actor,
    /// The light that it is on.
    pub light: LightId,
    /// The holder's number of the latest update that was valid, 0 before the first.
    pub update: u64,
    /// The latest valid command.
    pub command: Option<Command>,
    /// Why the latest update was refused, if it was.
    pub refusal: Option<EditRefusal>,
    /// What everybody sees of it.
    pub live: Option<LiveLight>,
    /// The latest record that its holder knew when it began; control points are counted as they were then.
    pub(crate) base_seq: u64,
    /// When it was last updated, on the owner's clock.
    pub(crate) updated_at_ms: u64,
}

/// A light as it is dragged: worked out once, at the update, for all who draw it and tell of it.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveLight {
    /// What would change in the document.
    pub changes: Vec<Change>,
    /// How the drag of a feature stands.
    pub outcome: Option<DragOutcome>,
    /// The light as the document has it.
    pub(crate) before: NumberedLight,
    /// The light with the changes.
    pub(crate) after: NumberedLight,
}

impl LiveLight {
    /// What `command` makes of `light`, which it changes and does not remove.
    pub(crate) fn of(
        light: LightId,
        document: &Document,
        command: &Command,
        context: CommandContext,
    ) -> Result<Self, EditRefusal> {
        let CommandResult { changes, document: after, outcome } =
            execute_command(document, command, context)?;
        let placed = |document: &Document| {
            let placed = document.lights().get(&light).cloned();
            placed.ok_or(EditRefusal::Edit(EditError::NoLight(light)))
        };
        Ok(Self { changes, outcome, before: placed(document)?, after: placed(&after)? })
    }
}

impl Gesture {
    /// What it would change in the document.
    pub fn changes(&self) -> &[Change] {
        self.live.as_ref().map_or(&[], |shown| &shown.changes)
    }
}

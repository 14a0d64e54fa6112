//! Drags under way: live for everybody, in no log, and a soft lock on one light each.

use document::{Change, Command};
use light::LightId;

use crate::{Actor, Refusal};

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
    pub refused: Option<Refusal>,
    /// What that would change in the document now.
    pub changes: Vec<Change>,
    /// The latest record that its holder knew when it began; control points are counted as they were then.
    pub(crate) base_seq: u64,
    /// When it was last updated, on the owner's clock.
    pub(crate) touched_ms: u64,
}

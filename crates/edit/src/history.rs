//! Which steps are in effect, and which undo or redo would take next.

use std::sync::Arc;

use rpds::RedBlackTreeMapSync;
use scene::Change;

use crate::{Action, Record, Scope};

/// Steps that can be undone at most; older ones stay in the log and in effect.
pub const MAX_UNDO_DEPTH: usize = 10_000;

/// Steps in effect and undos in effect, with what each changed.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    /// Edits that nothing has taken back, by sequence.
    steps: RedBlackTreeMapSync<u64, Step>,
    /// Undos that no redo has taken back and no later edit has ended, oldest first.
    undos: Vec<Undo>,
}

#[derive(Clone, Debug)]
struct Step {
    actor_id: String,
    changes: Arc<[Change]>,
}

#[derive(Clone, Debug)]
struct Undo {
    seq: u64,
    actor_id: String,
    scope: Scope,
    changes: Arc<[Change]>,
    /// The step that it took back.
    target: u64,
    step: Step,
}

impl History {
    /// The latest step of that scope: its sequence and what it changed.
    pub fn undo_target(&self, actor_id: &str, scope: Scope) -> Option<(u64, Arc<[Change]>)> {
        let mut latest = self.steps.iter().rev();
        let (&seq, step) = latest.find(|(_, step)| scope == Scope::Session || step.actor_id == actor_id)?;
        Some((seq, Arc::clone(&step.changes)))
    }

    /// The latest undo of that scope: its sequence and what it changed.
    pub fn redo_target(&self, actor_id: &str, scope: Scope) -> Option<(u64, Arc<[Change]>)> {
        let mut latest = self.undos.iter().rev().filter(|undo| undo.scope == scope);
        let undo = latest.find(|undo| scope == Scope::Session || undo.actor_id == actor_id)?;
        Some((undo.seq, Arc::clone(&undo.changes)))
    }

    /// Whether what `action` takes back, if it is an undo or a redo, is there to take back.
    pub fn is_in_effect(&self, action: &Action) -> bool {
        match action {
            Action::Edit(_) | Action::Gesture(_) => true,
            Action::Undo { target, .. } => self.steps.contains_key(target),
            Action::Redo { target, .. } => self.undos.iter().any(|undo| undo.seq == *target),
        }
    }

    /// Takes in the next record. What it takes back is in effect.
    pub fn note(&mut self, record: &Record) {
        let actor_id = record.actor.id.clone();
        let changes: Arc<[Change]> = record.changes.as_slice().into();
        match record.action {
            Action::Edit(_) | Action::Gesture(_) => {
                self.undos.retain(|undo| undo.scope == Scope::Mine && undo.actor_id != actor_id);
                self.steps.insert_mut(record.seq, Step { actor_id, changes });
                if self.steps.size() > MAX_UNDO_DEPTH
                    && let Some(oldest) = self.steps.first().map(|(seq, _)| *seq)
                {
                    self.steps.remove_mut(&oldest);
                }
            }
            Action::Undo { scope, target, .. } => {
                let Some(step) = self.steps.get(&target).cloned() else { return };
                self.steps.remove_mut(&target);
                self.undos.push(Undo { seq: record.seq, actor_id, scope, changes, target, step });
            }
            Action::Redo { target, .. } => {
                let Some(index) = self.undos.iter().position(|undo| undo.seq == target) else { return };
                let undo = self.undos.remove(index);
                self.steps.insert_mut(undo.target, undo.step);
            }
        }
    }
}

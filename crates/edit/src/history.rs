//! Steps in effect, and the next targets of undo and redo.
//!
//! Only the sequence numbers of records are kept. The record of a step has its changes. All collections share equal
//! parts between clones, so that the cost of an undo, or of a copy of the earlier state, does not grow with the
//! history.

use std::sync::Arc;

use rpds::{RedBlackTreeMapSync, RedBlackTreeSetSync};

use crate::{Action, UndoScope};

/// Maximum number of steps of one actor that can be undone. Older ones stay in the log and in effect.
pub const MAX_UNDO_DEPTH: usize = 10_000;

/// Steps and undos that are in effect, by the sequence of their records. No undo has reverted such a step, and no redo
/// such an undo.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    /// Actor of each step in effect.
    steps: RedBlackTreeMapSync<u64, Arc<str>>,
    /// Steps in effect and own undos of each actor.
    actors: RedBlackTreeMapSync<Arc<str>, ActorUndo>,
    /// Undos with [`UndoScope::Session`] that no redo has reverted and no later edit has ended.
    undos: Undos,
}

/// Steps and undos of one actor, for [`UndoScope::Mine`].
#[derive(Clone, Debug, Default)]
struct ActorUndo {
    steps: RedBlackTreeSetSync<u64>,
    undos: Undos,
}

/// Undos by the sequence of their records, each with the sequence of the step that it reverted and that step's actor.
type Undos = RedBlackTreeMapSync<u64, (u64, Arc<str>)>;

/// Undo in effect, as in a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PastUndo {
    /// Sequence of the undo's record.
    pub seq: u64,
    /// Actor who can redo it; `None` for an undo with [`UndoScope::Session`], which anybody can redo.
    pub actor_id: Option<String>,
    /// Sequence of the step that it reverted.
    pub target: u64,
    /// Actor of that step.
    pub target_actor_id: String,
}

impl History {
    /// Returns the latest step of a scope that can be undone. If `before` is given, only steps before that record
    /// count.
    pub fn undo_target(&self, actor_id: &str, scope: UndoScope, before: Option<u64>) -> Option<u64> {
        let until = ..before.unwrap_or(u64::MAX);
        match scope {
            UndoScope::Session => self.steps.range(until).next_back().map(|(seq, _)| *seq),
            UndoScope::Mine => self.actors.get(actor_id)?.steps.range(until).next_back().copied(),
        }
    }

    /// Returns the latest undo of a scope that can be redone. If `before` is given, only undos before that record
    /// count.
    pub fn redo_target(&self, actor_id: &str, scope: UndoScope, before: Option<u64>) -> Option<u64> {
        let until = ..before.unwrap_or(u64::MAX);
        self.undos(actor_id, scope)?.range(until).next_back().map(|(seq, _)| *seq)
    }

    /// Returns true if `action` is no undo or redo, or if its target is in effect and in the actor's scope.
    pub fn is_in_effect(&self, actor_id: &str, action: &Action) -> bool {
        match action {
            Action::Edit { .. } | Action::Gesture { .. } | Action::Group { .. } => true,
            Action::Undo { scope, target, .. } => {
                let mine = |by: &Arc<str>| *scope == UndoScope::Session || **by == *actor_id;
                self.steps.get(target).is_some_and(mine)
            }
            Action::Redo { scope, target, .. } => {
                self.undos(actor_id, *scope).is_some_and(|undos| undos.contains_key(target))
            }
        }
    }

    /// Adds record `seq`. The target of an undo or redo is in effect.
    pub fn add_record(&mut self, seq: u64, actor_id: &str, action: &Action) {
        match *action {
            Action::Edit { .. } | Action::Gesture { .. } | Action::Group { .. } => {
                for scope in [UndoScope::Session, UndoScope::Mine] {
                    self.set_undos(actor_id, scope, Undos::default());
                }
                self.add_step(seq, &self.shared_actor_id(actor_id));
            }
            Action::Undo { scope, target, .. } => {
                let Some(by) = self.steps.get(&target).cloned() else { return };
                self.remove_step(target, &by);
                let undos = self.undos(actor_id, scope).cloned().unwrap_or_default().insert(seq, (target, by));
                self.set_undos(actor_id, scope, undos);
            }
            Action::Redo { scope, target, .. } => {
                let Some(undos) = self.undos(actor_id, scope).cloned() else { return };
                let Some((step, by)) = undos.get(&target).cloned() else { return };
                self.set_undos(actor_id, scope, undos.remove(&target));
                self.add_step(step, &by);
            }
        }
    }

    /// Returns the sequence and actor of every step in effect, oldest first.
    pub fn steps(&self) -> impl Iterator<Item = (u64, &str)> {
        self.steps.iter().map(|(seq, by)| (*seq, &**by))
    }

    /// Returns all undos that can be redone.
    pub fn past_undos(&self) -> impl Iterator<Item = PastUndo> {
        let own = self.actors.iter().map(|(id, person)| (Some(id), &person.undos));
        own.chain([(None, &self.undos)]).flat_map(|(id, undos)| {
            undos.iter().map(move |(&seq, (target, by))| PastUndo {
                seq,
                actor_id: id.map(ToString::to_string),
                target: *target,
                target_actor_id: by.to_string(),
            })
        })
    }

    /// Restores the history from [`Self::steps`] and [`Self::past_undos`].
    pub fn restore<'a>(steps: impl Iterator<Item = (u64, &'a str)>, undos: &[PastUndo]) -> Self {
        let mut history = Self::default();
        for (seq, by) in steps {
            history.add_step(seq, &history.shared_actor_id(by));
        }
        for PastUndo { seq, actor_id, target, target_actor_id } in undos {
            let (id, scope) = match actor_id {
                Some(id) => (id.as_str(), UndoScope::Mine),
                None => ("", UndoScope::Session),
            };
            let by = history.shared_actor_id(target_actor_id);
            let undos = history.undos(id, scope).cloned().unwrap_or_default().insert(*seq, (*target, by));
            history.set_undos(id, scope, undos);
        }
        history
    }

    fn undos(&self, actor_id: &str, scope: UndoScope) -> Option<&Undos> {
        match scope {
            UndoScope::Session => Some(&self.undos),
            UndoScope::Mine => self.actors.get(actor_id).map(|person| &person.undos),
        }
    }

    fn set_undos(&mut self, actor_id: &str, scope: UndoScope, undos: Undos) {
        match scope {
            UndoScope::Session => self.undos = undos,
            UndoScope::Mine => {
                let person = self.actors.get(actor_id).cloned().unwrap_or_default();
                self.actors.insert_mut(self.shared_actor_id(actor_id), ActorUndo { undos, ..person });
            }
        }
    }

    /// Returns the shared copy of an actor's id, so that many steps use one string.
    fn shared_actor_id(&self, actor_id: &str) -> Arc<str> {
        self.actors.get_key_value(actor_id).map_or_else(|| actor_id.into(), |(id, _)| Arc::clone(id))
    }

    fn add_step(&mut self, seq: u64, by: &Arc<str>) {
        let mut person = self.actors.get(by).cloned().unwrap_or_default();
        person.steps.insert_mut(seq);
        self.steps.insert_mut(seq, Arc::clone(by));
        if person.steps.size() > MAX_UNDO_DEPTH
            && let Some(oldest) = person.steps.first().copied()
        {
            person.steps.remove_mut(&oldest);
            self.steps.remove_mut(&oldest);
        }
        self.actors.insert_mut(Arc::clone(by), person);
    }

    fn remove_step(&mut self, seq: u64, by: &Arc<str>) {
        self.steps.remove_mut(&seq);
        if let Some(mut person) = self.actors.get(by).cloned() {
            person.steps.remove_mut(&seq);
            self.actors.insert_mut(Arc::clone(by), person);
        }
    }
}

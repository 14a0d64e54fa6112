//! Which steps are in effect, and which undo or redo would take next.
//!
//! Only numbers of records are kept: what a step changed stands in its record. All collections share what is equal
//! between clones, so that neither an undo nor keeping the state before it costs more with a longer past.

use std::sync::Arc;

use rpds::{RedBlackTreeMapSync, RedBlackTreeSetSync};

use crate::{Action, UndoScope};

/// Steps of one person that can be undone at most; older ones stay in the log and in effect.
pub const MAX_UNDO_DEPTH: usize = 10_000;

/// Steps in effect and undos in effect, by the sequence of their records.
#[derive(Clone, Debug, Default)]
pub(crate) struct History {
    /// Who made each step that nothing has taken back.
    steps: RedBlackTreeMapSync<u64, Arc<str>>,
    /// The same steps and their own undos, by person.
    actors: RedBlackTreeMapSync<Arc<str>, ActorUndo>,
    /// Undos with [`UndoScope::Session`] that no redo has taken back and no later edit has ended.
    undos: Undos,
}

/// What one person can undo and redo with [`UndoScope::Mine`].
#[derive(Clone, Debug, Default)]
struct ActorUndo {
    steps: RedBlackTreeSetSync<u64>,
    undos: Undos,
}

/// By the sequence of the undo's record: the step that it took back, and who had made that.
type Undos = RedBlackTreeMapSync<u64, (u64, Arc<str>)>;

/// An undo in effect, as a checkpoint holds it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PastUndo {
    /// Its record.
    pub seq: u64,
    /// Who can redo it; `None` for an undo with [`UndoScope::Session`], which anybody can.
    pub actor_id: Option<String>,
    /// The step that it took back.
    pub target: u64,
    /// Who had made that step.
    pub target_actor_id: String,
}

impl History {
    /// The latest step of that scope, of those before record `before` where that is given.
    pub fn undo_target(&self, actor_id: &str, scope: UndoScope, before: Option<u64>) -> Option<u64> {
        let until = ..before.unwrap_or(u64::MAX);
        match scope {
            UndoScope::Session => self.steps.range(until).next_back().map(|(seq, _)| *seq),
            UndoScope::Mine => self.actors.get(actor_id)?.steps.range(until).next_back().copied(),
        }
    }

    /// The latest undo of that scope, of those before record `before` where that is given.
    pub fn redo_target(&self, actor_id: &str, scope: UndoScope, before: Option<u64>) -> Option<u64> {
        let until = ..before.unwrap_or(u64::MAX);
        self.undos(actor_id, scope)?.range(until).next_back().map(|(seq, _)| *seq)
    }

    /// Whether what `action` takes back, if it is an undo or a redo, is there for that person to take back.
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

    /// Takes in record `seq`. What it takes back is in effect.
    pub fn add_record(&mut self, seq: u64, actor_id: &str, action: &Action) {
        match *action {
            Action::Edit { .. } | Action::Gesture { .. } | Action::Group { .. } => {
                self.undos = Undos::default();
                self.set_undos(actor_id, Undos::default());
                self.add_step(seq, &self.shared_actor_id(actor_id));
            }
            Action::Undo { scope, target, .. } => {
                let Some(by) = self.steps.get(&target).cloned() else { return };
                self.remove_step(target, &by);
                let undos =
                    self.undos(actor_id, scope).cloned().unwrap_or_default().insert(seq, (target, by));
                self.set_undos_in_scope(actor_id, scope, undos);
            }
            Action::Redo { scope, target, .. } => {
                let Some(undos) = self.undos(actor_id, scope).cloned() else { return };
                let Some((step, by)) = undos.get(&target).cloned() else { return };
                self.set_undos_in_scope(actor_id, scope, undos.remove(&target));
                self.add_step(step, &by);
            }
        }
    }

    /// Every step in effect: its sequence and who made it, oldest first.
    pub fn steps(&self) -> impl Iterator<Item = (u64, &str)> {
        self.steps.iter().map(|(seq, by)| (*seq, &**by))
    }

    /// Every undo that can be redone.
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

    /// The history that [`Self::steps`] and [`Self::past_undos`] were taken of.
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
            history.set_undos_in_scope(id, scope, undos);
        }
        history
    }

    fn undos(&self, actor_id: &str, scope: UndoScope) -> Option<&Undos> {
        match scope {
            UndoScope::Session => Some(&self.undos),
            UndoScope::Mine => self.actors.get(actor_id).map(|person| &person.undos),
        }
    }

    fn set_undos_in_scope(&mut self, actor_id: &str, scope: UndoScope, undos: Undos) {
        match scope {
            UndoScope::Session => self.undos = undos,
            UndoScope::Mine => self.set_undos(actor_id, undos),
        }
    }

    fn set_undos(&mut self, actor_id: &str, undos: Undos) {
        let person = self.actors.get(actor_id).cloned().unwrap_or_default();
        self.actors.insert_mut(self.shared_actor_id(actor_id), ActorUndo { undos, ..person });
    }

    /// One copy of each person's id, however many steps they made.
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

//! Sessions: a document, its history, and the gestures in progress.

use std::collections::BTreeMap;
use std::sync::Arc;

use document::{
    Change, Command, CommandContext, Document, EditError, GroupResult, GroupedCommand, execute_command, execute_group,
    needs_solution,
};
use light::LightId;
use rpds::RedBlackTreeMapSync;

use crate::gesture::{Gesture, LEASE_MS, LiveLight, MAX_GESTURES};
use crate::history::{History, PastUndo};
use crate::undo::Reverted;
use crate::{Action, Actor, EditRefusal, Record, RecordedCommand, ReplayError, UndoScope};

/// Maximum number of records of a log.
pub const MAX_RECORDS: usize = 1_000_000;

/// Request to a session that ends in a record.
#[derive(Clone, Debug, PartialEq)]
pub enum EditRequest {
    /// Execution of a command.
    Edit {
        /// Latest record that the sender knew; `None` if not given.
        base_seq: Option<u64>,
        command: Command,
    },
    /// Execution of commands as one step, all or none.
    Group(Vec<GroupedEdit>),
    /// Commit of the gesture of this name.
    Commit(String),
    /// Undo of a step.
    Undo(UndoScope),
    /// Redo of an undone step.
    Redo(UndoScope),
}

/// Edit of a group.
#[derive(Clone, Debug, PartialEq)]
pub struct GroupedEdit {
    /// Latest record that the sender knew, as in [`EditRequest::Edit`].
    pub base_seq: Option<u64>,
    /// Command of the edit, with the solution of its drag.
    pub grouped: GroupedCommand,
}

/// Data that the owner of a session provides for a request.
#[derive(Default)]
pub struct EditSources<'a> {
    /// Data about the scene, for commands.
    pub context: CommandContext<'a>,
    /// Result of [`Session::find_revert`] for the request in the present state of the session.
    pub reverted: Option<Reverted>,
}

/// History of a session that the document does not contain. From document and history, a session continues after any
/// record as if it had replayed all records up to it. The lists are sorted by their first fields.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SessionHistory {
    /// Steps in effect: sequence of the record, and id of the actor.
    pub steps: Vec<(u64, String)>,
    /// Undos that can be redone.
    pub undos: Vec<PastUndo>,
    /// Latest record of each actor on each light.
    pub touched: Vec<(LightId, String, u64)>,
    /// Latest record that renumbered each light's control points.
    pub renumbered: Vec<(LightId, u64)>,
}

/// Document with its history and gestures, see the crate's documentation. Cloning a session costs as much as cloning
/// the document, and does not depend on the length of the log. So the owner can keep the state before a commit.
#[derive(Clone, Debug, Default)]
pub struct Session {
    document: Document,
    seq: u64,
    history: History,
    /// Latest record of each actor on each light.
    touched: RedBlackTreeMapSync<(LightId, Arc<str>), u64>,
    /// Latest record that renumbered each light's control points.
    renumbered: RedBlackTreeMapSync<LightId, u64>,
    /// Gestures in progress, by light. Each light has at most one.
    gestures: BTreeMap<LightId, Gesture>,
}

impl Session {
    /// Returns the document after the latest record.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// Returns the sequence of the latest record, 0 before the first.
    pub fn seq(&self) -> u64 {
        self.seq
    }

    /// Restores the session as it is after record `seq`. It equals a session that replayed all records up to this one.
    pub fn restore(document: Document, seq: u64, history: &SessionHistory) -> Self {
        let steps = history.steps.iter().map(|(seq, by)| (*seq, by.as_str()));
        let touched = history.touched.iter().map(|(light, by, seq)| ((*light, Arc::from(by.as_str())), *seq));
        Self {
            document,
            seq,
            history: History::restore(steps, &history.undos),
            touched: touched.collect(),
            renumbered: history.renumbered.iter().copied().collect(),
            gestures: BTreeMap::new(),
        }
    }

    /// Returns the history that [`Self::restore`] needs besides the document and the sequence number.
    pub fn session_history(&self) -> SessionHistory {
        let touched = self.touched.iter().map(|((light, by), seq)| (*light, by.to_string(), *seq));
        SessionHistory {
            steps: self.history.steps().map(|(seq, by)| (seq, by.to_owned())).collect(),
            undos: self.history.past_undos().collect(),
            touched: touched.collect(),
            renumbered: self.renumbered.iter().map(|(light, seq)| (*light, *seq)).collect(),
        }
    }

    /// Restores the document and history of `before`, an earlier state of this session. Gestures in progress stay, and
    /// what they change is computed again. Drags of features and of lights with hard pins need the scene for that. They
    /// keep their present state instead.
    pub fn roll_back_to(&mut self, before: Self, context: CommandContext) {
        let gestures = std::mem::take(&mut self.gestures);
        *self = Self { gestures, ..before };
        for gesture in self.gestures.values_mut() {
            if let Some(command) = &gesture.command
                && !needs_solution(&self.document, command)
            {
                gesture.live = LiveLight::of(gesture.light, &self.document, command, context).ok();
            }
        }
    }

    /// Applies a stored record. The owner of the records must check that no operation occurs twice.
    pub fn replay(&mut self, record: &Record) -> Result<(), ReplayError> {
        let seq = record.seq;
        if seq != self.seq + 1 {
            return Err(ReplayError::Gap { found: seq, after: self.seq });
        }
        if let Action::Undo { target, .. } | Action::Redo { target, .. } = record.action
            && !self.history.is_in_effect(&record.actor.id, &record.action)
        {
            return Err(ReplayError::TargetNotInEffect { seq, target });
        }
        let refused = |reason| ReplayError::Record { seq, reason };
        self.document.apply(&record.changes).map_err(refused)?;
        self.index_record(record);
        Ok(())
    }

    /// Updates the history from a record that the document has applied.
    fn index_record(&mut self, record: &Record) {
        let seq = record.seq;
        self.history.add_record(seq, &record.actor.id, &record.action);
        self.seq = seq;
        let actor_id: Arc<str> = record.actor.id.as_str().into();
        for change in &record.changes {
            let Some(light) = change.light() else { continue };
            self.touched.insert_mut((light, Arc::clone(&actor_id)), seq);
            if matches!(change, Change::ControlPoints { .. } | Change::Light { old: Some(_), new: Some(_), .. }) {
                self.renumbered.insert_mut(light, seq);
            }
        }
    }

    /// Executes a request and returns the record to store. `now_ms` is the time of day. The owner of the records
    /// ensures that an operation is executed once.
    ///
    /// The caller keeps a clone of the session as it was before until the record is stored, in order to restore it if
    /// storing fails.
    pub fn execute_request(
        &mut self,
        request: EditRequest,
        actor: &Actor,
        op_id: &str,
        now_ms: u64,
        sources: EditSources,
    ) -> Result<Record, EditRefusal> {
        if self.seq as usize >= MAX_RECORDS {
            let remedy = "make a new session from its document";
            return Err(EditRefusal::TooMany { what: "records", limit: MAX_RECORDS, remedy });
        }
        // A result for another state of the session is useless.
        let found = sources.reverted.filter(|found| found.seq == self.seq);
        let (action, changes, document) = match request {
            EditRequest::Edit { base_seq, command } => {
                let rebased = self.check_base_seq(&command, actor, base_seq)?;
                let edited = execute_command(&self.document, &command, sources.context)?;
                let outcome = edited.outcome.map(Box::new);
                (Action::Edit { command, rebased, outcome }, edited.changes, edited.document)
            }
            EditRequest::Group(edits) => {
                let mut rebased = false;
                for (index, GroupedEdit { base_seq, grouped }) in edits.iter().enumerate() {
                    let is_rebased = self.check_base_seq(&grouped.command, actor, *base_seq);
                    rebased |= is_rebased.map_err(|refusal| EditRefusal::in_group(index, refusal))?;
                }
                let commands = edits.iter().map(|edit| &edit.grouped);
                let together = execute_group(&self.document, commands, sources.context.scene_bounds);
                let of_group = |(index, error): (usize, EditError)| EditRefusal::in_group(index, error.into());
                let GroupResult { changes, document, outcomes } = together.map_err(of_group)?;
                let commands = edits.into_iter().map(|edit| edit.grouped.command).zip(outcomes);
                let recorded =
                    |(command, outcome): (_, Option<_>)| RecordedCommand { command, outcome: outcome.map(Box::new) };
                let edits = commands.map(recorded).collect();
                (Action::Group { edits, rebased }, changes, document)
            }
            EditRequest::Commit(id) => {
                let gesture = self.end_gesture(&id, actor)?;
                let Some(command) = gesture.command else {
                    return Err(gesture.refusal.unwrap_or(EditRefusal::EmptyGesture(id)));
                };
                let rebased = self.check_base_seq(&command, actor, Some(gesture.base_seq))?;
                let edited = execute_command(&self.document, &command, sources.context)?;
                let outcome = edited.outcome.map(Box::new);
                (Action::Gesture { command, rebased, outcome }, edited.changes, edited.document)
            }
            EditRequest::Undo(scope) => {
                let Reverted { target, changes, skipped, document, .. } =
                    found.ok_or(EditRefusal::NothingToUndo { passed: None })?;
                (Action::Undo { scope, target, skipped }, changes, document)
            }
            EditRequest::Redo(scope) => {
                let Reverted { target, changes, skipped, document, .. } =
                    found.ok_or(EditRefusal::NothingToRedo { passed: None })?;
                (Action::Redo { scope, target, skipped }, changes, document)
            }
        };
        self.check_locks(&changes, actor)?;
        let (actor, op_id) = (actor.clone(), op_id.to_owned());
        let record = Record { seq: self.seq + 1, time_ms: now_ms, actor, op_id, action, changes };
        self.document = document;
        self.index_record(&record);
        Ok(record)
    }

    pub(crate) fn history(&self) -> &History {
        &self.history
    }

    /// Returns the latest record of each actor on `light`.
    pub(crate) fn latest_records_on(&self, light: LightId) -> impl Iterator<Item = (&str, u64)> {
        let from = self.touched.range((light, Arc::from(""))..);
        from.take_while(move |((id, _), _)| *id == light).map(|((_, by), seq)| (&**by, *seq))
    }

    /// Refuses outdated indices of control points. Returns true if another actor changed the light since `base_seq`.
    fn check_base_seq(&self, command: &Command, actor: &Actor, base_seq: Option<u64>) -> Result<bool, EditRefusal> {
        let (Some(light), Some(base_seq)) = (command.light(), base_seq) else { return Ok(false) };
        if command.uses_point_indices() {
            self.check_numbering(light, base_seq)?;
        }
        Ok(self.latest_records_on(light).any(|(by, seq)| by != actor.id && seq > base_seq))
    }

    /// Refuses indices of control points of `light` as of record `base_seq` if they were renumbered since.
    fn check_numbering(&self, light: LightId, base_seq: u64) -> Result<(), EditRefusal> {
        match self.renumbered.get(&light) {
            Some(&seq) if seq > base_seq => Err(EditRefusal::Stale { light: self.document.light_name(light), seq }),
            _ => Ok(()),
        }
    }

    fn check_locks(&self, changes: &[Change], actor: &Actor) -> Result<(), EditRefusal> {
        changes.iter().filter_map(Change::light).try_for_each(|light| self.check_lock(light, actor))
    }

    fn check_lock(&self, light: LightId, actor: &Actor) -> Result<(), EditRefusal> {
        match self.gestures.get(&light) {
            Some(held) if held.actor.id != actor.id => {
                let light = self.document.light_name(light);
                Err(EditRefusal::Locked { light, holder: held.actor.name.clone() })
            }
            _ => Ok(()),
        }
    }

    /// Returns the gestures in progress, in the order of their lights.
    pub fn gestures(&self) -> impl Iterator<Item = &Gesture> {
        self.gestures.values()
    }

    /// Begins a gesture named `id` on `light`. `base_seq` is as in [`EditRequest::Edit`]. `client` is the connection
    /// with which the gesture ends. `now_ms` is any clock that only goes forward.
    pub fn begin_gesture(
        &mut self,
        id: &str,
        light: LightId,
        base_seq: u64,
        client: u64,
        actor: &Actor,
        now_ms: u64,
    ) -> Result<&Gesture, EditRefusal> {
        if !self.document.lights().contains_key(&light) {
            return Err(EditError::NoLight(light).into());
        }
        self.check_numbering(light, base_seq)?;
        self.check_lock(light, actor)?;
        if self.gestures.contains_key(&light) || self.gestures().any(|held| held.id == id && held.actor.id == actor.id)
        {
            return Err(EditRefusal::GestureExists(id.to_owned()));
        }
        if self.gestures.len() >= MAX_GESTURES {
            let remedy = "wait until one is let go";
            return Err(EditRefusal::TooMany { what: "gestures under way", limit: MAX_GESTURES, remedy });
        }
        Ok(self.gestures.entry(light).or_insert(Gesture {
            id: id.to_owned(),
            client,
            actor: actor.clone(),
            light,
            update: 0,
            command: None,
            refusal: None,
            live: None,
            base_seq,
            updated_at_ms: now_ms,
        }))
    }

    /// Updates the state of a drag. If the command is refused, the former state stays. The lease is renewed in any
    /// case.
    pub fn update_gesture(
        &mut self,
        id: &str,
        update: u64,
        command: Command,
        actor: &Actor,
        now_ms: u64,
        context: CommandContext,
    ) -> Result<&Gesture, EditRefusal> {
        let light = self.light_of_gesture(id, actor)?;
        let no_gesture = || EditRefusal::NoGesture(id.to_owned());
        let base_seq = self.gestures.get(&light).ok_or_else(no_gesture)?.base_seq;
        let shown = self.live_light(light, base_seq, &command, context);
        let gesture = self.gestures.get_mut(&light).ok_or_else(no_gesture)?;
        gesture.updated_at_ms = now_ms;
        gesture.refusal = shown.as_ref().err().cloned();
        (gesture.live, gesture.command, gesture.update) = (Some(shown?), Some(command), update);
        Ok(gesture)
    }

    /// Computes the result of `command` as the state of a drag of `light` that began at record `base_seq`.
    fn live_light(
        &self,
        light: LightId,
        base_seq: u64,
        command: &Command,
        context: CommandContext,
    ) -> Result<LiveLight, EditRefusal> {
        if command.light() != Some(light) || matches!(command, Command::RemoveLight(_)) {
            return Err(EditRefusal::OtherLight(self.document.light_name(light)));
        }
        if command.uses_point_indices() {
            self.check_numbering(light, base_seq)?;
        }
        LiveLight::of(light, &self.document, command, context)
    }

    /// Ends a gesture without a record.
    pub fn end_gesture(&mut self, id: &str, actor: &Actor) -> Result<Gesture, EditRefusal> {
        let light = self.light_of_gesture(id, actor)?;
        self.gestures.remove(&light).ok_or_else(|| EditRefusal::NoGesture(id.to_owned()))
    }

    /// Ends the gestures of a closed connection.
    pub fn end_gestures_of(&mut self, client: u64) -> Vec<Gesture> {
        self.gestures.extract_if(.., |_, gesture| gesture.client == client).map(|(_, gesture)| gesture).collect()
    }

    /// Renews the leases of an actor's gestures.
    pub fn renew_gestures_of(&mut self, actor: &Actor, now_ms: u64) {
        for gesture in self.gestures.values_mut().filter(|gesture| gesture.actor.id == actor.id) {
            gesture.updated_at_ms = now_ms;
        }
    }

    /// Ends the gestures whose leases have expired.
    pub fn expire_gestures(&mut self, now_ms: u64) -> Vec<Gesture> {
        let over = |gesture: &Gesture| now_ms.saturating_sub(gesture.updated_at_ms) > LEASE_MS;
        self.gestures.extract_if(.., |_, gesture| over(gesture)).map(|(_, gesture)| gesture).collect()
    }

    fn light_of_gesture(&self, id: &str, actor: &Actor) -> Result<LightId, EditRefusal> {
        let mut mine = self.gestures().filter(|held| held.id == id && held.actor.id == actor.id);
        mine.next().map(|held| held.light).ok_or_else(|| EditRefusal::NoGesture(id.to_owned()))
    }

    /// Returns the document as everybody sees it, with the gestures in progress. A gesture that no longer fits, because
    /// its light is removed, has no effect.
    pub fn live_document(&self) -> Document {
        let mut live = self.document.clone();
        for (light, shown) in self.gestures().filter_map(|gesture| Some((gesture.light, gesture.live.as_ref()?))) {
            if self.document.lights().get(&light) == Some(&shown.before) {
                live.set_live_light(light, &shown.after);
                shown.added.iter().for_each(|added| live.add_live_light(added));
            } else {
                // The holder has changed another property of the light since the update.
                let _ = live.apply(&shown.changes);
            }
        }
        live
    }
}

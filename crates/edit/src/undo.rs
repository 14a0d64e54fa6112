//! Targets and changes of undo and redo, with later changes that prevent parts of them.

use document::{Change, CommandResult, Document, EditError};

use crate::{EditRefusal, EditRequest, Record, Session};

/// Maximum number of steps that undo and redo pass over because nothing of them can be reverted.
pub const MAX_STEPS_PASSED_OVER: usize = 1_000;
/// Maximum number of distinct reasons kept for all steps that are passed over.
const MAX_REASONS: usize = 8;
/// Maximum number of properties of a step for which the refusal names the actor who changed them later.
const MAX_NAMED_PROPERTIES: usize = 8;
/// Maximum number of records in which that actor is searched: the latest ones on the light.
const MAX_SEARCHED_RECORDS: usize = 8;

/// Finds an earlier record by its sequence.
pub type FindRecord<'a> = &'a dyn Fn(u64) -> Option<Record>;

/// Result of undo or redo in the present state of a session.
#[derive(Clone, Debug)]
pub struct Reverted {
    /// Sequence of the latest record in the state for which this was computed.
    pub(crate) seq: u64,
    /// Document after the undo or redo.
    pub(crate) document: Document,
    /// Sequence of the record to revert. Of later steps nothing can be reverted.
    pub target: u64,
    /// Changes to make, at least one.
    pub changes: Vec<Change>,
    /// Changes that cannot be reverted, with the reasons, a sentence each.
    pub skipped: Vec<String>,
    /// Reasons in `skipped` that belong to later steps, which were passed over.
    pub passed: Vec<String>,
}

impl Session {
    /// Finds the changes for an undo or redo; `None` for another request.
    ///
    /// The target is the latest step of which something is left. A step is passed over if each of its properties was
    /// changed since or cannot be reverted. It stays in effect, since it can be undone once the obstacle is gone. At
    /// most [`MAX_STEPS_PASSED_OVER`] steps are passed over.
    pub fn find_revert(
        &self,
        request: &EditRequest,
        actor_id: &str,
        find_record: FindRecord,
    ) -> Result<Option<Reverted>, EditRefusal> {
        let (EditRequest::Undo(scope) | EditRequest::Redo(scope)) = *request else { return Ok(None) };
        let undoes = matches!(request, EditRequest::Undo(_));
        let mut passed: Vec<String> = Vec::new();
        let mut target = None;
        let mut seen = 0;
        for _ in 0..=MAX_STEPS_PASSED_OVER {
            target = if undoes {
                self.history().undo_target(actor_id, scope, target)
            } else {
                self.history().redo_target(actor_id, scope, target)
            };
            let Some(target) = target else { break };
            seen += 1;
            let record = find_record(target).ok_or(EditRefusal::MissingRecord(target))?;
            let RevertParts { revert: left, changed_since, blocked_reasons: stays } =
                revert_changes(self.document(), &record.changes);
            let since = |(n, change): (usize, &Change)| {
                let later =
                    (n < MAX_NAMED_PROPERTIES).then(|| self.later_change_of(change, target, find_record)).flatten();
                match &later {
                    Some((who, removal @ Change::Light { new: None, .. })) => {
                        format!("{who} has removed {} since", removal.subject(self.document()))
                    }
                    Some((who, _)) => format!("{who} has changed {} since", change.subject(self.document())),
                    None => format!("somebody has changed {} since", change.subject(self.document())),
                }
            };
            if let Some(CommandResult { changes, document, .. }) = left {
                let since = changed_since.iter().enumerate().map(since);
                let skipped = passed.iter().cloned().chain(since).chain(stays).collect();
                return Ok(Some(Reverted { seq: self.seq(), document, target, changes, skipped, passed }));
            }
            let room = MAX_REASONS.saturating_sub(passed.len());
            for why in changed_since.iter().enumerate().map(since).chain(stays).take(room) {
                if !passed.contains(&why) {
                    passed.push(why);
                }
            }
        }
        let nothing = if seen > MAX_STEPS_PASSED_OVER {
            Some(format!("nothing is left of the latest {MAX_STEPS_PASSED_OVER} steps"))
        } else {
            (seen > 0).then(|| "the latest steps changed nothing".into())
        };
        let passed = passed.into_iter().next().or(nothing);
        Err(if undoes { EditRefusal::NothingToUndo { passed } } else { EditRefusal::NothingToRedo { passed } })
    }

    /// Finds the change after record `target` that gave the property of `change` its present value, and the name of its
    /// actor. `None` if the latest records on the light do not contain it.
    fn later_change_of(&self, change: &Change, target: u64, find_record: FindRecord) -> Option<(String, Change)> {
        let light = change.light()?;
        let mut seqs: Vec<u64> =
            self.latest_records_on(light).map(|(_, seq)| seq).filter(|seq| *seq > target).collect();
        seqs.sort_unstable_by(|a, b| b.cmp(a));
        seqs.into_iter().take(MAX_SEARCHED_RECORDS).filter_map(find_record).find_map(|record| {
            let later = record.changes.into_iter().find(|later| later.overrides(change))?;
            Some((record.actor.name, later))
        })
    }
}

/// Division of a step's changes into those that can be reverted and those that cannot.
struct RevertParts {
    /// Changes to make; `None` if there are none.
    revert: Option<CommandResult>,
    /// Changes that cannot be reverted, because their property has another value now.
    changed_since: Vec<Change>,
    /// Reasons why other changes cannot be reverted, a sentence each: they would leave something invalid.
    blocked_reasons: Vec<String>,
}

/// Reverts `changes` in the present `document`.
///
/// A property whose value differs from the new value of its change stays: somebody has changed it since. The remaining
/// changes of a light are reverted together or, if that would leave a light that cannot be evaluated, not at all.
fn revert_changes(document: &Document, changes: &[Change]) -> RevertParts {
    let inverses = Change::inverses(changes);
    let mut parts = RevertParts { revert: None, changed_since: Vec::new(), blocked_reasons: Vec::new() };
    // Without any old value no change is possible. Many such steps are passed over without a copy of the document.
    if !inverses.iter().any(|change| document.holds_old_value_of(change)) {
        parts.changed_since = inverses;
        return parts;
    }
    let (mut changes, mut after) = (Vec::new(), document.clone());
    for group in inverses.chunk_by(|a, b| a.light().is_some() && a.light() == b.light()) {
        let (held, changed): (Vec<_>, Vec<_>) =
            group.iter().cloned().partition(|change| after.holds_old_value_of(change));
        parts.changed_since.extend(changed);
        match after.apply(&held) {
            Ok(()) => changes.extend(held),
            Err(error) => {
                // The subject already names the light.
                let reason = match &error {
                    EditError::InvalidLight { reason, .. } => reason.to_string(),
                    other => other.to_string(),
                };
                let why = |change: &Change| format!("{} cannot go back: {reason}", change.subject(document));
                parts.blocked_reasons.extend(held.iter().map(why));
            }
        }
    }
    parts.revert = (!changes.is_empty()).then_some(CommandResult { changes, document: after, outcome: None });
    parts
}

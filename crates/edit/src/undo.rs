//! What undo and redo take back, where later changes may stand in the way.

use document::{Change, CommandResult, Document, EditError};

use crate::{EditRefusal, EditRequest, Record, Session};

/// Steps of which nothing is left to take back that undo and redo look past at most.
pub const MAX_STEPS_PASSED_OVER: usize = 1_000;
/// Sentences about what stays, of the steps that are passed over, each once.
const MAX_REASONS: usize = 8;
/// Properties of a step for which is said who has changed them since.
const MAX_NAMED_PROPERTIES: usize = 8;
/// Who that was is looked for in the latest records of so many people.
const MAX_SEARCHED_RECORDS: usize = 8;

/// Finds a record of the past by its sequence.
pub type FindRecord<'a> = &'a dyn Fn(u64) -> Option<Record>;

/// What undo or redo comes to in a session as it is.
#[derive(Clone, Debug)]
pub struct Reverted {
    /// The latest record of that session.
    pub(crate) seq: u64,
    /// The document after it.
    pub(crate) document: Document,
    /// The record that is taken back. Of those after it that could have been, nothing is left.
    pub target: u64,
    /// The changes to make; there is one at least.
    pub changes: Vec<Change>,
    /// What stays, and why, a sentence each.
    pub skipped: Vec<String>,
    /// Those of them that are of later steps, which were passed over.
    pub passed: Vec<String>,
}

impl Session {
    /// What `request` of that actor takes back; `None` where it is no undo or redo.
    ///
    /// It is the latest step of which something is left: a step whose every property has been changed since, or cannot
    /// go back, is passed over and stays in effect, as it can be taken back once what stands in its way is. At most
    /// [`MAX_STEPS_PASSED_OVER`] are passed over.
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
                let later = (n < MAX_NAMED_PROPERTIES)
                    .then(|| self.later_change_of(change, target, find_record))
                    .flatten();
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
        Err(if undoes {
            EditRefusal::NothingToUndo { passed }
        } else {
            EditRefusal::NothingToRedo { passed }
        })
    }

    /// What gave the property of `change` its value after record `target`, and the name of who did it, where that can be
    /// told from the latest records on its light.
    fn later_change_of(
        &self,
        change: &Change,
        target: u64,
        find_record: FindRecord,
    ) -> Option<(String, Change)> {
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

/// What taking back changes comes to.
struct RevertParts {
    /// The changes to make, where there are any.
    revert: Option<CommandResult>,
    /// What has another value by now.
    changed_since: Vec<Change>,
    /// What would leave something invalid, a sentence each.
    blocked_reasons: Vec<String>,
}

/// The changes that take back `changes` in `document` as it is now.
///
/// A property that no longer has the value it was given stays: somebody has changed it since. What is left of a
/// light is taken back as a whole or, where that would leave a light that cannot be evaluated, not at all.
fn revert_changes(document: &Document, changes: &[Change]) -> RevertParts {
    let inverses: Vec<Change> = changes.iter().rev().map(Change::inverse).collect();
    let mut parts = RevertParts { revert: None, changed_since: Vec::new(), blocked_reasons: Vec::new() };
    // Then none can be made, and none after it: many such are passed over without a copy of the document.
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
                // The subject names the light already.
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

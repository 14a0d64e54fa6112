//! Targets of undo and redo against the rules evaluated over the whole log: slow, and easy to verify.

use std::collections::BTreeSet;

use document::{Change, Document};
use edit::{Action, EditRefusal, Record, UndoScope};
use proptest::prelude::*;

use crate::properties::{RandomStep, random_steps, request};
use crate::support::{TestSession, angle};

fn is_edit(record: &Record) -> bool {
    matches!(record.action, Action::Edit { .. } | Action::Gesture { .. } | Action::Group { .. })
}

fn target(record: &Record) -> Option<u64> {
    match record.action {
        Action::Undo { target, .. } | Action::Redo { target, .. } => Some(target),
        Action::Edit { .. } | Action::Gesture { .. } | Action::Group { .. } => None,
    }
}

/// Returns true if nothing reverts the record, or if its revert is itself reverted.
fn is_in_effect(log: &[Record], record: &Record) -> bool {
    let takers = log.iter().filter(|later| target(later) == Some(record.seq));
    takers.filter(|taker| is_in_effect(log, taker)).count() == 0
}

fn is_seen(record: &Record, who: &str, scope: UndoScope) -> bool {
    scope == UndoScope::Session || record.actor.id == who
}

/// UNDO-7. Returns true if a change of the record, or its changes of one light, can be reverted in the present
/// document.
fn can_revert_something(document: &Document, record: &Record) -> bool {
    let inverses = Change::inverses(&record.changes);
    let lights: BTreeSet<_> = inverses.iter().filter_map(Change::light).collect();
    let of_light = |light| inverses.iter().filter(move |change| change.light() == Some(light));
    let single = inverses.iter().filter(|change| change.light().is_none()).map(|change| vec![change.clone()]);
    let held = |change: &&Change| document.holds_old_value_of(change);
    let together = lights.into_iter().map(|light| of_light(light).filter(held).cloned().collect());
    single.chain(together).any(|changes| !changes.is_empty() && document.clone().apply(&changes).is_ok())
}

/// UNDO-1. Returns the latest step in effect, of the actor or of anybody, of which something is left.
fn undo_target(log: &[Record], document: &Document, who: &str, scope: UndoScope) -> Option<u64> {
    let steps = log.iter().rev().filter(|record| is_edit(record) && is_seen(record, who, scope));
    let mut left = steps.filter(|record| is_in_effect(log, record) && can_revert_something(document, record));
    left.next().map(|record| record.seq)
}

/// UNDO-3. Returns the latest undo of that scope in effect, with no edit since by the actor or by anybody, of which
/// something is left.
fn redo_target(log: &[Record], document: &Document, who: &str, scope: UndoScope) -> Option<u64> {
    let of_scope = |record: &&Record| matches!(record.action, Action::Undo { scope: its, .. } if its == scope);
    let undos = log.iter().rev().filter(of_scope).filter(|record| is_seen(record, who, scope));
    let is_ended =
        |undo: &Record| log.iter().any(|later| later.seq > undo.seq && is_edit(later) && is_seen(later, who, scope));
    let mut left =
        undos.filter(|undo| is_in_effect(log, undo) && !is_ended(undo) && can_revert_something(document, undo));
    left.next().map(|undo| undo.seq)
}

/// Returns the target that the session chose.
fn chosen(answer: Result<Record, EditRefusal>) -> Option<u64> {
    match answer {
        Ok(record) => target(&record),
        Err(EditRefusal::NothingToUndo { .. } | EditRefusal::NothingToRedo { .. }) => None,
        other => panic!("{other:?}"),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Rules: UNDO-1, UNDO-3, UNDO-5
    #[test]
    fn undo_and_redo_take_what_the_rules_say(play in random_steps(&["ada", "ben", "cyd"], 60)) {
        let mut studio = TestSession::new();
        for (who, step) in play {
            let expected = match step {
                RandomStep::Undo(scope) => undo_target(&studio.log, studio.session.document(), who, scope),
                RandomStep::Redo(scope) => redo_target(&studio.log, studio.session.document(), who, scope),
                RandomStep::Edit(_) | RandomStep::Group(_) => {
                    let _ = studio.ask(who, request(step, &studio));
                    continue;
                }
            };
            prop_assert_eq!(chosen(studio.ask(who, request(step, &studio))), expected);
        }
    }
}

/// The comparison above can fail: a log with another actor for a step gives other targets.
///
/// Rules: UNDO-1, UNDO-3
#[test]
fn the_model_sees_who_did_what() {
    let mut studio = TestSession::new();
    studio.edit("ada", angle(30.0));
    studio.edit("ben", angle(40.0));
    studio.undo("ben");
    let document = studio.session.document();
    let model = |log: &[Record]| {
        (undo_target(log, document, "ada", UndoScope::Mine), redo_target(log, document, "ben", UndoScope::Mine))
    };
    assert_eq!(model(&studio.log), (Some(2), Some(4)));
    let mut planted = studio.log.clone();
    planted[1].actor.id = "ben".into();
    planted[3].actor.id = "ada".into();
    assert_eq!(model(&planted), (None, None));
    let mut later = studio.log.clone();
    later.push(Record { seq: 5, ..studio.log[2].clone() });
    assert_eq!(model(&later), (Some(2), None), "an edit of his own ends his redo");
}

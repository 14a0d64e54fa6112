//! Undo and redo, step by step.

use std::time::Instant;

use document::Command;
use edit::{Action, EditRefusal, EditRequest, MAX_STEPS_PASSED_OVER, MAX_UNDO_DEPTH, UndoScope};
use glam::{DQuat, DVec3};
use light::parameters::TRANSLATION;

use crate::support::{KEY, TestSession, angle, bent_light, insert, position, radius, softness};

/// Rules: UNDO-1, REC-1
#[test]
fn undo_is_a_record_like_any_other() {
    let mut studio = TestSession::new();
    let before = studio.hash();
    let edit = studio.edit("ada", angle(40.0));
    let undo = studio.undo("ada");
    assert_eq!(undo.seq, edit.seq + 1);
    assert_eq!(undo.action, Action::Undo { scope: UndoScope::Mine, target: edit.seq, skipped: Vec::new() });
    assert_eq!(undo.changes, [edit.changes[0].inverse()]);
    assert_eq!(studio.hash(), before);
}

/// Rules: UNDO-1
#[test]
fn mine_passes_over_the_steps_of_others() {
    let mut studio = TestSession::new();
    studio.edit("ada", angle(40.0));
    studio.edit("ben", softness(0.5));
    studio.undo("ada");
    assert_eq!((studio.angle(), studio.softness()), (25.0, 0.5), "theirs stays");
    let refused = studio.ask("ada", EditRequest::Undo(UndoScope::Mine)).expect_err("nothing of hers is left");
    assert_eq!(refused, EditRefusal::NothingToUndo { passed: None });
}

/// Rules: UNDO-1
#[test]
fn session_takes_back_whoever_was_last() {
    let mut studio = TestSession::new();
    let undo = |studio: &mut TestSession| studio.done("cyd", EditRequest::Undo(UndoScope::Session)).changes.len();
    studio.edit("ada", angle(40.0));
    studio.edit("ben", softness(0.5));
    undo(&mut studio);
    assert_eq!((studio.angle(), studio.softness()), (40.0, 0.2));
    undo(&mut studio);
    assert_eq!((studio.angle(), studio.softness()), (25.0, 0.2));
    undo(&mut studio);
    assert!(studio.session.document().lights().is_empty(), "the light itself was a step");
    studio.ask("cyd", EditRequest::Undo(UndoScope::Session)).expect_err("that was all");
}

/// Rules: UNDO-2
#[test]
fn undo_skips_and_names_later_changes_of_others() {
    let mut studio = TestSession::new();
    let (translation, rotation) = (Some(DVec3::X), Some(DQuat::from_rotation_x(0.5)));
    studio.edit("ada", Command::PlaceLight { light: KEY, translation, rotation, scale: None, ignore_pins: false });
    studio.edit("ben", Command::SetLight { light: KEY, setting: TRANSLATION.to(DVec3::Y), ignore_pins: false });
    let undo = studio.undo("ada");
    assert_eq!(undo.action.skipped(), ["BEN has changed the translation of “key” since"]);
    let transform = studio.light().transform();
    assert_eq!((transform.translation, transform.rotation), (DVec3::Y, DQuat::IDENTITY));
}

/// Rules: UNDO-7, UNDO-5
#[test]
fn a_step_of_which_nothing_is_left_is_passed_over() {
    let mut studio = TestSession::new();
    let first = studio.edit("ada", softness(0.5));
    studio.edit("ada", radius(1, 0.3));
    studio.edit("ben", radius(1, 0.35));
    let undo = studio.undo("ada");
    let gone = "BEN has changed the radius of control point 1 of “key” since";
    assert_eq!(undo.action, Action::Undo { scope: UndoScope::Mine, target: first.seq, skipped: vec![gone.into()] });
    assert_eq!((studio.softness(), studio.radius(1)), (0.2, 0.35));

    let seq = studio.session.seq();
    let refused = studio.ask("ada", EditRequest::Undo(UndoScope::Mine)).expect_err("nothing of hers is left");
    assert_eq!(refused.to_string(), format!("there is nothing to undo: {gone}"));
    assert_eq!(refused, EditRefusal::NothingToUndo { passed: Some(gone.into()) });
    assert_eq!(studio.session.seq(), seq, "it is no step");

    studio.undo("ben");
    let undo = studio.undo("ada");
    assert!(matches!(undo.action, Action::Undo { target: 3, .. }), "what stood in its way is gone");
    assert_eq!(studio.radius(1), 0.4);
    for _ in 0..2 {
        assert!(studio.redo("ada").action.skipped().is_empty());
    }
    assert_eq!((studio.softness(), studio.radius(1)), (0.5, 0.3));
}

/// Rules: UNDO-7
#[test]
fn a_redo_of_which_nothing_is_left_is_no_step() {
    let mut studio = TestSession::new();
    studio.edit("ada", radius(1, 0.3));
    studio.undo("ada");
    studio.edit("ben", radius(1, 0.35));
    let refused = studio.ask("ada", EditRequest::Redo(UndoScope::Mine)).expect_err("nothing to bring back");
    let gone = "BEN has changed the radius of control point 1 of “key” since";
    assert_eq!(refused.to_string(), format!("there is nothing to redo: {gone}"));
    assert_eq!(refused, EditRefusal::NothingToRedo { passed: Some(gone.into()) });
}

/// Another actor on the same light is not named. If the actor is not found, nobody is named.
///
/// Rules: UNDO-2
#[test]
fn who_changed_it_since_is_the_one_who_did() {
    let mut studio = TestSession::new();
    studio.edit("ada", radius(1, 0.3));
    studio.edit("ben", radius(1, 0.35));
    studio.edit("cyd", softness(0.6));
    let check = |studio: &TestSession, expected: &str| {
        let refused = studio.clone().ask("ada", EditRequest::Undo(UndoScope::Mine)).expect_err("changed since");
        assert!(refused.to_string().ends_with(expected), "{refused}, not {expected}");
    };
    check(&studio, "BEN has changed the radius of control point 1 of “key” since");
    studio.edit("ben", softness(0.7));
    check(&studio, "somebody has changed the radius of control point 1 of “key” since");
    studio.edit("cyd", Command::RemoveLight(KEY));
    check(&studio, "CYD has removed “key” since");
}

/// A command without an effect is a record all the same. Undo takes the step before it.
///
/// Rules: UNDO-7, CMD-4
#[test]
fn a_step_that_changed_nothing_is_passed_over() {
    let mut studio = TestSession::new();
    let edit = studio.edit("ada", angle(40.0));
    studio.edit("ada", angle(40.0));
    let undo = studio.undo("ada");
    assert_eq!(undo.action, Action::Undo { scope: UndoScope::Mine, target: edit.seq, skipped: Vec::new() });
    assert_eq!(studio.angle(), 25.0);
    let refused = studio.ask("ada", EditRequest::Undo(UndoScope::Mine)).expect_err("nothing is left");
    assert_eq!(refused.to_string(), "there is nothing to undo: the latest steps changed nothing");
}

/// The search is bounded, however many steps were overridden.
///
/// Rules: UNDO-7
#[test]
fn so_many_steps_are_passed_over() {
    let mut studio = TestSession::new();
    studio.edit("ada", softness(0.5));
    for step in 0..MAX_STEPS_PASSED_OVER {
        studio.edit("ada", angle(20.0 + (step % 50) as f64));
    }
    studio.edit("ben", angle(80.0));
    let undo = studio.clone().undo("ada");
    assert!(matches!(undo.action, Action::Undo { target: 2, .. }), "{:?}", undo.action);
    assert_eq!(undo.action.skipped(), ["BEN has changed the cone angle of “key” since"], "once");
    let mut one_more = studio.clone();
    one_more.undo("ben");
    one_more.edit("ada", angle(81.0));
    one_more.edit("ben", angle(80.0));
    let refused = one_more.ask("ada", EditRequest::Undo(UndoScope::Mine)).expect_err("too many");
    assert!(matches!(refused, EditRefusal::NothingToUndo { passed: Some(_) }), "{refused}");
}

/// Rules: UNDO-2, DOC-2
#[test]
fn a_point_of_an_outdated_numbering_is_skipped() {
    let mut studio = TestSession::new();
    studio.edit("ada", softness(0.5));
    studio.edit("ada", radius(2, 0.5));
    studio.edit("ben", insert(1));
    let undo = studio.undo("ada");
    assert_eq!(undo.action.skipped(), ["BEN has changed the radius of control point 2 of “key” since"]);
    assert_eq!(studio.light().points().len(), 5);
    studio.done("ben", EditRequest::Undo(UndoScope::Mine));
    assert_eq!((studio.light().points().len(), studio.radius(2)), (4, 0.5), "the old numbering is back");
}

/// Rules: UNDO-2, CMD-2
#[test]
fn undo_skips_a_change_that_would_fold_the_tube() {
    let mut studio = TestSession::new();
    studio.edit("ada", radius(1, 0.05));
    studio.edit("ada", radius(2, 0.05));
    studio.edit("ben", radius(3, 0.05));
    // A bend that the thin tube can have and the wide one cannot.
    studio.edit("ben", position(2, 1.2, -2.0));
    let before = studio.hash();
    // The later of her two steps would leave the fold, and then so would the earlier one.
    let refused = studio.ask("ada", EditRequest::Undo(UndoScope::Mine)).expect_err("a fold");
    let why = refused.to_string();
    let stays = "there is nothing to undo: the radius of control point 2 of “key” cannot go back: ";
    assert!(why.starts_with(stays) && why.contains("folds"), "{why}");
    assert_eq!(studio.hash(), before);
}

/// Rules: UNDO-2, CMD-3
#[test]
fn undo_skips_a_removed_light() {
    let mut studio = TestSession::new();
    studio.edit("ada", angle(40.0));
    studio.edit("ben", Command::RemoveLight(KEY));
    let refused = studio.ask("ada", EditRequest::Undo(UndoScope::Mine)).expect_err("the light is gone");
    assert_eq!(refused.to_string(), "there is nothing to undo: BEN has removed “key” since");
    studio.undo("ben");
    assert_eq!(studio.angle(), 40.0, "as it was when it went");
}

/// Rules: UNDO-3, UNDO-5
#[test]
fn an_edit_ends_what_its_actor_can_redo() {
    let nothing = |studio: &TestSession, who: &str, scope| {
        studio.clone().ask(who, EditRequest::Redo(scope)) == Err(EditRefusal::NothingToRedo { passed: None })
    };
    let mut studio = TestSession::new();
    assert!(nothing(&studio, "ada", UndoScope::Mine) && nothing(&studio, "ada", UndoScope::Session));
    studio.edit("ada", angle(40.0));
    studio.undo("ada");
    assert!(!nothing(&studio, "ada", UndoScope::Mine));
    assert!(nothing(&studio, "ada", UndoScope::Session), "it was not undone for the session");
    assert!(nothing(&studio, "ben", UndoScope::Mine), "it is not his");
    studio.edit("ben", softness(0.5));
    assert!(!nothing(&studio, "ada", UndoScope::Mine), "another's edit ends nothing of hers");
    studio.edit("ada", softness(0.6));
    assert!(nothing(&studio, "ada", UndoScope::Mine));

    studio.done("ada", EditRequest::Undo(UndoScope::Session));
    assert!(!nothing(&studio, "ben", UndoScope::Session), "anybody can redo for the session");
    studio.edit("cyd", angle(50.0));
    assert!(nothing(&studio, "ben", UndoScope::Session), "and any edit ends it");
}

/// Rules: UNDO-3, UNDO-1
#[test]
fn redo_brings_steps_back_latest_undo_first() {
    let mut studio = TestSession::new();
    for degrees in [30.0, 40.0, 50.0] {
        studio.edit("ada", angle(degrees));
    }
    studio.undo("ada");
    let second = studio.undo("ada");
    let redo = studio.redo("ada");
    assert_eq!(redo.action, Action::Redo { scope: UndoScope::Mine, target: second.seq, skipped: Vec::new() });
    assert_eq!(studio.angle(), 40.0);
    let undo = studio.undo("ada");
    assert!(matches!(undo.action, Action::Undo { target: 3, .. }), "what was redone can be undone again");
    studio.redo("ada");
    studio.redo("ada");
    assert_eq!(studio.angle(), 50.0);
    studio.ask("ada", EditRequest::Redo(UndoScope::Mine)).expect_err("all are back");
}

/// Rules: UNDO-1, DOC-1
#[test]
fn a_light_comes_back_as_itself() {
    let mut studio = TestSession::new();
    let placed = studio.session.document().lights()[&KEY].clone();
    studio.edit("ada", Command::RemoveLight(KEY));
    studio.undo("ada");
    assert_eq!(studio.session.document().lights()[&KEY], placed);
    studio.redo("ada");
    studio.edit("ada", Command::AddLight(bent_light()));
    assert!(!studio.session.document().lights().contains_key(&KEY), "its number is not used again");
}

/// Rules: UNDO-6
#[test]
fn a_scripts_batch_takes_nobody_elses_steps() {
    let mut studio = TestSession::new();
    studio.edit("ada", angle(40.0));
    for step in 0..=MAX_UNDO_DEPTH {
        studio.edit("script", softness(if step % 2 == 0 { 0.3 } else { 0.4 }));
    }
    let undo = studio.undo("ada");
    assert!(matches!(undo.action, Action::Undo { target: 2, .. }), "{:?}", undo.action);
    assert_eq!(studio.angle(), 25.0);
    let undone = (0..=MAX_UNDO_DEPTH).take_while(|_| studio.ask("script", EditRequest::Undo(UndoScope::Mine)).is_ok());
    assert_eq!(undone.count(), MAX_UNDO_DEPTH, "its own first step is past the limit");
}

/// With a history nine times as long no undo takes longer. If each undo copied the history, it took 16 times as long,
/// so the bound of 4 leaves the same factor on either side.
///
/// Rules: UNDO-1
#[test]
fn an_undo_costs_no_more_with_a_long_history() {
    let seconds_of_undos = |depth: usize| {
        let mut studio = TestSession::new();
        for step in 0..depth {
            studio.edit("ada", angle(20.0 + (step % 50) as f64));
        }
        let started = Instant::now();
        for _ in 0..500 {
            // A server keeps the session before each request, too.
            let before = studio.session.clone();
            studio.undo("ada");
            drop(before);
        }
        started.elapsed().as_secs_f64()
    };
    // Best of three of each, in turns: other load on the machine lengthens either.
    let best = |depth| (0..3).map(|_| seconds_of_undos(depth)).fold(f64::INFINITY, f64::min);
    let (short, long) = (best(1_000), best(9_000));
    assert!(long < 4.0 * short, "{short} s with 1,000 steps, {long} s with 9,000");
}

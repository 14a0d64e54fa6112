//! Groups of commands that are one step.

use document::{Change, Command, LightPin};
use drag::{DragPin, PinKind, PinTarget};
use edit::{Action, EditRefusal, EditRequest, GroupedEdit, UndoScope};
use glam::DVec3;
use light::LightId;

use crate::properties::grouped;
use crate::support::{KEY, TestSession, angle, bent_light, insert, position, radius, softness};

fn group(commands: impl IntoIterator<Item = Command>) -> EditRequest {
    EditRequest::Group(commands.into_iter().map(grouped).collect())
}

fn pin_of(light: LightId) -> Command {
    let pin = DragPin { kind: PinKind::Lit, at: PinTarget::Point(DVec3::ZERO), caster: None, is_hard: true };
    Command::AddPin(LightPin { light, pin })
}

/// Rules: CMD-17, UNDO-1, REC-9
#[test]
fn a_group_is_one_record_and_one_step() {
    let mut studio = TestSession::new();
    let before = studio.hash();
    let record = studio.done("ada", group([angle(30.0), softness(0.5), angle(40.0)]));
    assert_eq!((record.seq, record.changes.len()), (2, 2), "each property once");
    assert_eq!((studio.angle(), studio.softness()), (40.0, 0.5));
    assert!(matches!(&record.action, Action::Group { edits, rebased: false } if edits.len() == 3));
    studio.undo("ada");
    assert_eq!(studio.hash(), before);
    studio.redo("ada");
    assert_eq!((studio.angle(), studio.softness()), (40.0, 0.5));
}

/// A light added in a group can be changed in it, and is removed with it.
///
/// Rules: CMD-17, UNDO-1
#[test]
fn a_light_that_comes_in_a_group_goes_as_a_whole() {
    let mut studio = TestSession::new();
    let before = studio.hash();
    let new = LightId(studio.session.document().last_number() + 1);
    let of_new = |command| match command {
        Command::SetLight { setting, .. } => Command::SetLight { light: new, setting, ignore_pins: false },
        other => other,
    };
    let commands = [Command::AddLight(bent_light()), of_new(angle(30.0)), pin_of(new), pin_of(KEY)];
    let record = studio.done("ada", group(commands));
    let kinds: Vec<bool> = record.changes.iter().map(|change| matches!(change, Change::Pin { .. })).collect();
    assert_eq!(kinds, [true, false, true], "a light and its pins in a row");
    studio.undo("ada");
    assert_eq!(studio.hash(), before);
    // The removal of lights with their pins is reverted too.
    studio.redo("ada");
    let with = studio.hash();
    studio.done("ada", group([Command::RemoveLight(KEY), Command::RemoveLight(new)]));
    assert!(studio.session.document().lights().is_empty() && studio.session.document().pins().is_empty());
    studio.undo("ada");
    assert_eq!(studio.hash(), with);
}

/// Rules: CMD-17, CMD-4
#[test]
fn an_object_added_and_removed_is_no_change() {
    let mut studio = TestSession::new();
    let new = LightId(studio.session.document().last_number() + 1);
    let record = studio.done("ada", group([Command::AddLight(bent_light()), Command::RemoveLight(new)]));
    assert_eq!(record.changes, []);
}

/// Rules: CMD-17, CMD-1
#[test]
fn a_group_with_one_that_is_refused_does_nothing() {
    let mut studio = TestSession::new();
    let (before, seq) = (studio.hash(), studio.session.seq());
    let refused = studio.ask("ada", group([angle(30.0), softness(7.0), angle(40.0)])).expect_err("one is refused");
    let said = refused.to_string();
    assert!(said.starts_with("edit 2 of the group: ") && said.ends_with("nothing of the group was done"), "{said}");
    assert_eq!((studio.hash(), studio.session.seq()), (before, seq));
}

/// Rules: CMD-17, UNDO-2
#[test]
fn undo_of_a_group_leaves_later_changes_of_others() {
    let mut studio = TestSession::new();
    studio.done("ada", group([angle(40.0), softness(0.5)]));
    studio.edit("ben", softness(0.7));
    let undo = studio.undo("ada");
    assert_eq!((studio.angle(), studio.softness()), (25.0, 0.7));
    assert_eq!(undo.action.skipped(), ["BEN has changed the cone softness of “key” since"]);
}

/// A group uses the numbering that its sender knew, and then its own.
///
/// Rules: CMD-17, DOC-2
#[test]
fn control_points_are_counted_as_the_group_leaves_them() {
    let mut studio = TestSession::new();
    let seq = studio.session.seq();
    let based = |command| GroupedEdit { base_seq: Some(seq), ..grouped(command) };
    let edits = [insert(1), position(4, 0.4, -6.5), radius(4, 0.9)];
    let before = studio.hash();
    let record = studio.done("ada", EditRequest::Group(edits.clone().map(based).into()));
    assert!(matches!(record.changes[..], [Change::ControlPoints { .. }]), "{:?}", record.changes);
    assert_eq!((studio.light().points().len(), studio.radius(4)), (5, 0.9));
    let stale = studio.ask("ben", EditRequest::Group(edits.map(based).into())).expect_err("they were renumbered");
    assert!(
        matches!(&stale, EditRefusal::InGroup { number: 1, reason } if matches!(**reason, EditRefusal::Stale { .. }))
    );
    studio.done("ada", EditRequest::Undo(UndoScope::Mine));
    assert_eq!(studio.hash(), before);
}

/// Rules: CMD-17, GEST-3
#[test]
fn a_light_that_another_holds_is_left_alone_by_a_whole_group() {
    let mut studio = TestSession::new();
    let ben = crate::support::actor("ben");
    studio.session.begin_gesture("drag", KEY, 1, 1, &ben, 0).expect("free");
    let before = studio.hash();
    let refused = studio.ask("ada", group([Command::AddLight(bent_light()), angle(30.0)]));
    assert!(matches!(refused, Err(EditRefusal::Locked { .. })) && studio.hash() == before);
    let group = EditRequest::Group(vec![GroupedEdit { base_seq: Some(0), ..grouped(angle(30.0)) }]);
    assert!(studio.is_rebased("ben", group), "the rig made it after what he knew");
}

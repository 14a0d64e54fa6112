//! A light that is bent in place, in pixels and in the log.

use light::ParameterOwner;
use light::parameters::RANGE;
use protocol::{Action, ClientMessage, Command, GestureStatus, Record, Scope};

use crate::sessions::support::{Mirror, Server, committed, rename, state_of};

/// Number of values that differ by more than 1 of 255.
fn apart(a: &[u8], b: &[u8]) -> usize {
    assert_eq!(a.len(), b.len(), "pictures of two sizes");
    a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 1).count()
}

fn owner(mirror: &Mirror, light: u64) -> ParameterOwner {
    mirror.document.lights()[&light::LightId(light)].light.light().owner()
}

fn bend(light: u64) -> Command {
    Command::BendLight { light, segments: None, range: None, cone_angle: None, toward: None, ignore_pins: false }
}

/// Range in a record's command, if that bends a light.
fn bent_range(record: &Record) -> Option<f64> {
    match &record.action {
        Action::Edit { command: Command::BendLight { range, .. }, .. }
        | Action::Gesture { command: Command::BendLight { range, .. }, .. } => *range,
        _ => None,
    }
}

/// The demo's key light is straightened, bent in place, and both are undone. No pixel changes with the bending, and its
/// handles are where it shines.
///
/// Rules: CMD-12, DOC-2
#[test]
fn a_light_bends_in_place_without_a_pixel_changing() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    ada.open_view();
    let (light, start) = (ada.light(), ada.seq);
    let curved = ada.settled(start);
    ada.edited(Command::StraightenLight { light, ignore_pins: false });
    ada.edited(Command::SetLight { light, parameter: RANGE.to(None).into(), ignore_pins: false })
        .seq()
        .expect("committed");
    assert_eq!(owner(&ada, light), ParameterOwner::Spot);
    let straight = ada.settled(ada.seq);
    let visibly = apart(&curved, &straight);
    assert!(visibly > 300, "a straight light looks other than the curved one: {visibly} values");

    let bent = ada.edited(bend(light)).seq().expect("committed");
    assert_eq!(apart(&straight, &ada.settled(bent)), 0, "values that change");

    // The record contains the range that the room found, so replay needs no scene.
    let range = bent_range(&server.records(bent)[0]).expect("a range");
    let last = ada.point(4);
    let scale = ada.document.lights()[&light::LightId(light)].light.light().transform().scale;
    assert!((last[2] + range / scale).abs() < 1e-9);
    assert!((1.0..20.0).contains(&range), "the axis meets the table {range} units away");

    // The planted fault: a displaced control point is detected.
    let moved = ada.shift_point(4, [0.5, 0.0, 0.0]);
    assert!(apart(&straight, &ada.settled(moved)) > 100);

    for _ in 0..2 {
        ada.undo(Scope::Mine).seq().expect("committed");
    }
    assert_eq!(owner(&ada, light), ParameterOwner::Spot);
    assert!(ada.settled(ada.seq) == straight, "the same pixels");
}

/// Commands after a light is bent wait until the scene has answered. A gesture that bends a light shows it too, and its
/// record is complete as well.
///
/// Rules: CMD-12, GEST-8
#[test]
fn commands_after_a_bend_are_carried_out_after_it() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    let (light, seq) = (ada.light(), ada.seq);
    let straighten = || Command::StraightenLight { light, ignore_pins: false };
    let op_ids = [straighten(), bend(light), rename(light, "bent"), straighten()].map(|command| ada.edit(command));
    let seqs = op_ids.map(|op_id| committed(&ada.result(&op_id)));
    assert_eq!(seqs, [1, 2, 3, 4].map(|after| seq + after));

    ada.catch_up(seqs[3]);
    let base_seq = ada.seq;
    ada.send(&ClientMessage::GestureBegin { gesture: "bend".into(), light, base_seq });
    ada.update("bend", 1, bend(light));
    ada.commit("bend");
    let shown = state_of(&mut ada, |state| state.update == 1);
    assert_eq!((shown.status, shown.changes.len()), (GestureStatus::Held { refused: None }, 1));
    committed(&ada.result("commit"));
    let ranges: Vec<_> = server.records(seq + 2).iter().filter_map(bent_range).collect();
    assert!(matches!(ranges[..], [one, other] if one == other), "{ranges:?}");
}

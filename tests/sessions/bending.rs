//! A light that is bent in place, in pixels and in the log.

use light::ParameterOwner;
use light::parameters::RANGE;
use protocol::{Action, ClientMessage, Command, GestureStatus, Record, Scope};

use crate::sessions::support::{Mirror, Server, committed, move_point, moved, rename, state_of};

/// Number of values that differ by more than 1 of 255.
fn apart(a: &[u8], b: &[u8]) -> usize {
    assert_eq!(a.len(), b.len(), "pictures of two sizes");
    a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > 1).count()
}

fn owner(mirror: &Mirror, light: u64) -> ParameterOwner {
    mirror.document.lights()[&light::LightId(light)].light.light().owner()
}

/// The demo's key light is straightened, bent in place, and both are undone. No pixel changes with the bending, and its
/// handles are where it shines.
///
/// Rules: CMD-12, DOC-2
#[test]
fn a_light_bends_in_place_without_a_pixel_changing() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    ada.open_view();
    let (light, start) = (ada.light(), ada.seq);
    let curved = ada.settled(start);
    ada.edited(Command::StraightenLight { light });
    let endless = Command::SetLight { light, parameter: RANGE.to(None).into() };
    let straightened = ada.edited(endless).seq().expect("committed");
    assert_eq!(owner(&ada, light), ParameterOwner::Spot);
    let straight = ada.settled(straightened);
    let visibly = apart(&curved, &straight);
    assert!(visibly > 300, "a straight light looks other than the curved one: {visibly} values");

    let bent = ada
        .edited(Command::BendLight { light, segments: None, range: None, cone_angle: None, toward: None })
        .seq()
        .expect("committed");
    assert_eq!(apart(&straight, &ada.settled(bent)), 0, "values that change");

    // The record contains the range that the room found, so replay needs no scene.
    let log = server.process.get(&format!("/sessions/main/log?from={bent}&limit=1")).expect("answered");
    let record: serde_json::Value = serde_json::from_str(&log.text()).expect("a record");
    let range = record["action"]["command"]["range"].as_f64().expect("a range");
    let last = ada.point(4);
    assert!(
        (last[2] + range / ada.document.lights()[&light::LightId(light)].light.light().transform().scale)
            .abs()
            < 1e-9
    );
    assert!((1.0..20.0).contains(&range), "the axis meets the table {range} units away");

    // The planted fault: a displaced control point is detected.
    let moved = ada.edited(move_point(light, 4, moved(last, [0.5, 0.0, 0.0]))).seq().expect("committed");
    assert!(apart(&straight, &ada.settled(moved)) > 100);

    let undo = |ada: &mut Mirror| {
        let op_id = ada.op_id();
        ada.send(&ClientMessage::Undo { op_id: op_id.clone(), scope: Scope::Mine });
        ada.result(&op_id).seq().expect("committed")
    };
    undo(&mut ada);
    let undone = undo(&mut ada);
    assert_eq!(owner(&ada, light), ParameterOwner::Spot);
    assert!(ada.settled(undone) == straight, "the same pixels");
}

/// Commands after a light is bent wait until the scene has answered. A gesture that bends a light shows it too, and its
/// record is complete as well.
///
/// Rules: CMD-12, GEST-8
#[test]
fn what_is_sent_behind_a_light_that_is_bent_comes_after_it() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    let (light, seq) = (ada.light(), ada.seq);
    let bend = || Command::BendLight { light, segments: None, range: None, cone_angle: None, toward: None };
    let in_a_row = [
        Command::StraightenLight { light },
        bend(),
        rename(light, "bent"),
        Command::StraightenLight { light },
    ];
    let asked = in_a_row.map(|command| ada.edit(command));
    let seqs = asked.map(|op_id| committed(&ada.result(&op_id)));
    assert_eq!(seqs, [1, 2, 3, 4].map(|after| seq + after));

    ada.catch_up(seqs[3]);
    let base_seq = ada.seq;
    ada.send(&ClientMessage::GestureBegin { gesture: "bend".into(), light, base_seq });
    ada.send(&ClientMessage::GestureUpdate { gesture: "bend".into(), update: 1, command: bend() });
    ada.send(&ClientMessage::GestureCommit { gesture: "bend".into(), op_id: "commit".into() });
    let shown = state_of(&mut ada, |state| state.update == 1);
    assert_eq!((shown.status, shown.changes.len()), (GestureStatus::Held { refused: None }, 1));
    committed(&ada.result("commit"));
    let log = server.process.get(&format!("/sessions/main/log?from={}", seq + 2)).expect("answered").text();
    let records = log.lines().filter_map(|line| serde_json::from_str::<Record>(line).ok());
    let ranges: Vec<_> = records
        .filter_map(|record| match record.action {
            Action::Edit { command: Command::BendLight { range, .. }, .. }
            | Action::Gesture { command: Command::BendLight { range, .. }, .. } => Some(range),
            _ => None,
        })
        .collect();
    assert!(matches!(ranges[..], [Some(one), Some(other)] if one == other), "{ranges:?}");
}

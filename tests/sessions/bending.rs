//! A light that is bent in place, seen in pixels and in the log.

use light::Owner;
use light::parameters::RANGE;
use protocol::{ClientMessage, Command, Scope};

use crate::support::{Mirror, Server, move_point, moved};

/// A pixel's channels differ by so much where a shadow's edge, of two maps by two ways, is a little beside its place.
const EDGE: u8 = 16;

/// How many values differ by more than 1 of 255, and how many visibly.
fn apart(a: &[u8], b: &[u8]) -> [usize; 2] {
    [1, EDGE].map(|most| a.iter().zip(b).filter(|(a, b)| a.abs_diff(**b) > most).count())
}

fn owner(mirror: &Mirror, light: u64) -> Owner {
    mirror.document.lights()[&light::LightId(light)].light.light().owner()
}

/// The demo's key light made straight, bent in place, and both taken back: no pixel changes with the bending, and its
/// handles lie where it shines.
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
    assert_eq!(owner(&ada, light), Owner::Spot);
    let straight = ada.settled(straightened);
    let [_, visibly] = apart(&curved, &straight);
    assert!(visibly > 300, "a straight light looks other than the curved one: {visibly} values");

    let bent = ada
        .edited(Command::BendLight { light, segments: None, range: None, cone_angle: None, toward: None })
        .seq()
        .expect("committed");
    let [more_than_one, visibly] = apart(&straight, &ada.settled(bent));
    // A thousandth of the values lies on edges of shadows, which two maps do not resolve alike.
    assert!(
        more_than_one * 1000 <= straight.len() && visibly * 10_000 <= straight.len(),
        "{more_than_one} {visibly}"
    );

    // What the room has found out is in the record, which so needs no scene.
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

    // The planted fault: a control point beside its place is seen.
    let moved = ada.edited(move_point(light, 4, moved(last, [0.5, 0.0, 0.0]))).seq().expect("committed");
    assert!(apart(&straight, &ada.settled(moved))[1] > 100);

    let undo = |ada: &mut Mirror| {
        let op_id = ada.op_id();
        ada.send(&ClientMessage::Undo { op_id: op_id.clone(), scope: Scope::Mine });
        ada.result(&op_id).seq().expect("committed")
    };
    undo(&mut ada);
    let undone = undo(&mut ada);
    assert_eq!(owner(&ada, light), Owner::Spot);
    assert!(ada.settled(undone) == straight, "the same pixels");
}

//! Alternatives of dragged shadows in sessions: listed with pictures, chosen live, and a linked copy as one step.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use light::Links;
use light::parameters::LIGHT_LINK;
use protocol::{
    Action, Command, Drag, DragAlternative, DragChoice, DragKind, DragOutcome, DragRadii, GestureStatus, Pin, PinKind,
    PinTarget, Scope, parse_body,
};
use serde_json::{Value, json};

use crate::sessions::support::{Mirror, Server, committed, drag_ends, frame_pixels, ok, pixels, rejected, state_of};

const SIZE: [u32; 2] = [640, 360];
/// A pixel in the shadow of the blue vase's neck, and one farther down the table.
const FROM: [f64; 2] = [430.5, 265.5];
const TO: [f64; 2] = [430.5, 300.5];

fn drag(mirror: &Mirror, alternative: DragChoice) -> Command {
    let camera = mirror.document.cameras().values().next().expect("the demo has a camera");
    Command::DragFeature(Box::new(Drag {
        light: mirror.light(),
        kind: DragKind::Shadow,
        alternative: Some(alternative),
        points: None,
        radii: DragRadii::Keep,
        camera: camera.into(),
        size: SIZE,
        from: FROM,
        to: TO,
        pins: None,
        alternatives: false,
        source_outside: Some(true),
    }))
}

fn listed(server: &Server) -> Vec<Value> {
    let query = json!([{
        "light": 0, "kind": "shadow", "size": SIZE, "from": FROM, "to": TO, "sourceOutside": true, "alternatives": true,
    }]);
    let answers: Vec<Value> =
        parse_body(&ok(server.post("/sessions/main/drags", &query)).text()).expect("an array of results");
    answers[0]["alternatives"].as_array().expect("alternatives").clone()
}

/// Returns the outcome of the drag in a record.
fn recorded(server: &Server, seq: u64) -> DragOutcome {
    let record = server.records(seq).remove(0);
    let (Action::Edit { outcome, .. } | Action::Gesture { outcome, .. }) = record.action else { panic!("no drag") };
    *outcome.expect("a drag has an outcome")
}

/// Pixels of the session's picture, as small as a thumbnail.
fn picture(server: &Server) -> Vec<u8> {
    pixels(&ok(server.get("/sessions/main/render?size=160x90&samples=4")).body)
}

/// Largest difference of two pictures in steps of 255.
fn difference(a: &[u8], b: &[u8]) -> u8 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().expect("pixels")
}

/// The list names each alternative with its outcome and its picture: the session's picture after the drag with that
/// alternative. Nothing is edited.
///
/// Rules: DRAG-8, HTTP-23
#[test]
fn alternatives_are_listed_with_their_pictures() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    let (before, unmoved) = (server.state(), picture(&server));
    let all = listed(&server);
    assert_eq!(server.state(), before, "nothing is edited");
    assert!(all.len() >= 3, "{} alternatives", all.len());
    assert!(all.iter().any(|one| one["alternative"] == "linkedCopy" && one["copy"].is_object()));
    for one in &all {
        if one["status"] == "refused" {
            assert!(one["thumbnail"].is_null() && one["changedShare"].is_null(), "{one}");
            continue;
        }
        let share = one["changedShare"].as_f64().expect("a share");
        assert!(share > 0.0 && share < 0.5, "{share}");
        let choice: DragChoice = serde_json::from_value(one["alternative"].clone()).expect("a choice");
        committed(&ada.edited(drag(&ada, choice)));
        let thumbnail = pixels(&STANDARD.decode(one["thumbnail"].as_str().expect("a picture")).expect("base64"));
        let after = picture(&server);
        // Shadow maps of two documents differ in the last bit of a depth.
        assert!(difference(&thumbnail, &after) <= 2, "{} {}", one["alternative"], difference(&thumbnail, &after));
        // Deliberate fault that the check must detect: the picture before the drag.
        assert!(difference(&thumbnail, &unmoved) > 20);
        committed(&ada.undo(Scope::Mine));
    }
}

/// The best is the first of the list, live and committed. Its outcome names it, in the record too.
///
/// Rules: DRAG-8, REC-7
#[test]
fn the_best_is_taken_live_and_named() {
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let first = listed(&server)[0].clone();
    ada.begin("drag");
    ada.update("drag", 1, drag(&ada, DragChoice::Best));
    let state = state_of(&mut ada, |state| state.update == 1);
    assert_eq!(state.status, GestureStatus::Held { refused: None });
    let outcome = state.outcome.expect("an outcome");
    assert_eq!(json!(outcome.alternative), first["alternative"]);
    assert_eq!(json!(outcome.changed_share), first["changedShare"]);
    state_of(&mut ben, |state| state.update == 1);
    ada.commit("drag");
    let seq = committed(&ada.result("commit"));
    assert_eq!(recorded(&server, seq), *outcome);
    // Another alternative is another light.
    committed(&ada.undo(Scope::Mine));
    let one = committed(&ada.edited(drag(&ada, DragChoice::WholeLight)));
    assert_eq!(recorded(&server, one).alternative, Some(DragAlternative::WholeLight));
}

/// A picture of a drag in progress shows the light that the drag adds: it is the picture after the commit.
///
/// Rules: DRAG-8, FRAME-1
#[test]
fn a_linked_copy_is_seen_live() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    ben.open_view();
    let seen_live = |ada: &mut Mirror, ben: &mut Mirror, alternative| {
        ada.begin("drag");
        ada.update("drag", 1, drag(ada, alternative));
        let revision = state_of(ada, |state| state.update == 1).live_revision;
        let (header, tiles) = ben.frame(|header| header.flags.is_settled && header.live_revision >= revision);
        frame_pixels(&header, &tiles)
    };
    let live = seen_live(&mut ada, &mut ben, DragChoice::LinkedCopy);
    ada.commit("drag");
    let seq = committed(&ada.result("commit"));
    let after = ben.settled(seq);
    // Shadow maps of two documents differ in the last bit of a depth.
    assert!(difference(&live, &after) <= 2, "{}", difference(&live, &after));
    // Deliberate fault that the check must detect: the dragged light without its copy, as one that does not illuminate the vase.
    committed(&ada.undo(Scope::Mine));
    let key = ada.light();
    let links = LIGHT_LINK.to(Links::new(Vec::new(), vec!["blue vase".into()])).into();
    committed(&ada.edited(Command::SetLight { light: key, parameter: links, ignore_pins: false }));
    let without = seen_live(&mut ada, &mut ben, DragChoice::WholeLight);
    assert!(difference(&without, &after) > 20);
}

/// A linked copy adds a light that illuminates the caster alone and takes the caster's pins along. Live it is seen by all;
/// it is one record, and one step takes it back.
///
/// Rules: DRAG-8, REC-2, UNDO-1
#[test]
fn a_linked_copy_is_one_step() {
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let key = ada.light();
    let at = PinTarget::Node("blue vase".into());
    let pin = Pin { kind: PinKind::Look, light: key, at, caster: None, hard: true };
    committed(&ada.edited(Command::AddPin { pin }));
    let before = server.state().1;
    ada.begin("drag");
    ada.update("drag", 1, drag(&ada, DragChoice::LinkedCopy));
    let mine = state_of(&mut ada, |state| state.update == 1);
    assert_eq!(mine.status, GestureStatus::Held { refused: None });
    let others = state_of(&mut ben, |state| state.update == 1);
    assert_eq!(others.changes, mine.changes);
    ada.commit("drag");
    let seq = committed(&ada.result("commit"));
    ben.catch_up(seq);
    let document = protocol::Document::from(&ben.document);
    let lights = serde_json::to_value(&document.lights).expect("JSON");
    let links: Vec<&Value> =
        lights.as_array().expect("lights").iter().map(|light| &light["light"]["lightLink"]).collect();
    let vase = json!(["blue vase"]);
    assert!(links.iter().any(|links| links["exclude"] == vase), "{lights}");
    assert!(links.iter().any(|links| links["include"] == vase), "{lights}");
    assert_ne!(document.pins[0].pin.light, key, "the pin is the copy's");
    // The pin no longer limits the light, which does not illuminate the vase.
    let mut back = drag(&ada, DragChoice::WholeLight);
    let [from, to] = drag_ends(&mut back);
    std::mem::swap(from, to);
    committed(&ada.edited(back));
    committed(&ada.undo(Scope::Mine));
    committed(&ada.undo(Scope::Mine));
    assert_eq!(server.state().1, before);
    // A command is solved one way.
    let mut all = drag(&ada, DragChoice::Best);
    let Command::DragFeature(fields) = &mut all else { panic!() };
    fields.alternatives = true;
    assert!(rejected(&ada.edited(all)).message.contains("`alternatives`"));
}

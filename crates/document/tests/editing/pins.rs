//! Addition, change and removal of pins. Drags test their conditions.

use document::{Change, Command, Document, EditError, LightPin, MAX_PINS, PinId, describe_changes};
use drag::{DragPin, PinKind, PinTarget};
use glam::DVec3;
use light::LightId;
use light::parameters::NAME;
use scene::MAX_PATH_BYTES;

use crate::support::{BENDY, ROOM, SPOT, checked, done, refused, sample, spot, take_back};

fn pin(light: LightId, kind: PinKind) -> LightPin {
    let at = DVec3::new(1.0, -0.25, 3.5);
    LightPin { light, pin: DragPin { kind, at: PinTarget::Point(at), caster: Some("vase".into()), is_hard: true } }
}

fn added(document: &mut Document, light: LightId) -> PinId {
    let changes = done(document, &Command::AddPin(pin(light, PinKind::Shadow)));
    let [Change::Pin { pin, old: None, new: Some(_) }] = changes[..] else { panic!("{changes:?}") };
    pin
}

/// Rules: DOC-1, DOC-4, DOC-6, CMD-1
#[test]
fn a_pin_comes_changes_and_goes() {
    let mut document = sample();
    let before = document.hash();
    let id = added(&mut document, BENDY);
    let with = document.hash();
    assert_ne!(before, with);
    let soft = done(&mut document, &Command::SetPin { pin: id, is_hard: false });
    assert!(!document.pins()[&id].pin.is_hard && document.hash() != with);
    assert_eq!(done(&mut document, &Command::SetPin { pin: id, is_hard: false }), [], "it is so already");
    take_back(&mut document, &soft);
    assert_eq!(document.hash(), with);
    let gone = done(&mut document, &Command::RemovePin(id));
    assert_eq!((document.hash(), describe_changes(&gone, &document)), (before, "removing a pin of “key”".to_owned()));
    let other = added(&mut document, BENDY);
    assert!(other > id, "no number is used twice");
}

/// Rules: DOC-4
#[test]
fn every_part_of_a_pin_is_in_the_hash() {
    let hash_of = |pin: LightPin| {
        let mut document = sample();
        done(&mut document, &Command::AddPin(pin));
        document.hash()
    };
    let one = pin(BENDY, PinKind::Shadow);
    let of = |change: fn(&mut DragPin)| {
        let mut other = one.clone();
        change(&mut other.pin);
        hash_of(other)
    };
    let hashes = [
        hash_of(one.clone()),
        hash_of(LightPin { light: SPOT, ..one.clone() }),
        of(|pin| pin.kind = PinKind::Lit),
        of(|pin| pin.kind = PinKind::Direction),
        of(|pin| pin.kind = PinKind::Shadowed),
        of(|pin| pin.at = PinTarget::Point(DVec3::new(1.0, 0.25, 3.0))),
        of(|pin| pin.kind = PinKind::Look),
        of(|pin| pin.kind = PinKind::Coordinates),
        of(|pin| pin.at = PinTarget::Node("vase".into())),
        of(|pin| pin.caster = None),
        of(|pin| pin.caster = Some(String::new())),
        of(|pin| pin.is_hard = false),
    ];
    for (i, hash) in hashes.iter().enumerate() {
        assert!(!hashes[..i].contains(hash), "variant {i} has the hash of another");
    }
    assert_eq!(of(|pin| pin.caster = Some("vase".into())), hashes[0], "the same pin, the same hash");
}

/// Rules: DOC-6, UNDO-1
#[test]
fn pins_go_with_their_light_and_come_back_with_it() {
    let mut document = sample();
    added(&mut document, BENDY);
    let others = added(&mut document, SPOT);
    let hash = document.hash();
    let removal = done(&mut document, &Command::RemoveLight(BENDY));
    assert_eq!(document.pins().keys().copied().collect::<Vec<_>>(), [others]);
    take_back(&mut document, &removal);
    assert_eq!(document.hash(), hash);
    done(&mut document, &Command::LoadScene { asset: ROOM, name: "room".into() });
    assert!(document.pins().is_empty());
}

/// The pin stays without a light if the addition of the light is undone.
///
/// Rules: DOC-6
#[test]
fn a_pin_outlives_a_light_that_was_taken_back() {
    let mut document = sample();
    let addition = done(&mut document, &Command::AddLight(checked(spot())));
    let light = addition[0].light().expect("a light");
    let id = added(&mut document, light);
    let hash = document.hash();
    take_back(&mut document, &addition);
    assert!(document.pins().contains_key(&id) && !document.lights().contains_key(&light));
    document.apply(&addition).expect("it comes back");
    assert_eq!(document.hash(), hash);
    done(&mut document, &Command::SetLight { light, setting: NAME.to("again".into()), ignore_pins: false });
}

/// Rules: CMD-1, DOC-6
#[test]
fn invalid_pins_are_refused() {
    let mut document = sample();
    let nobodys = LightId(99);
    assert_eq!(refused(&document, &Command::AddPin(pin(nobodys, PinKind::Lit))), EditError::NoLight(nobodys));
    assert_eq!(refused(&document, &Command::RemovePin(PinId(99))), EditError::NoPin(PinId(99)));
    let mut nowhere = pin(BENDY, PinKind::Lit);
    nowhere.pin.at = PinTarget::Point(DVec3::NAN);
    assert_eq!(refused(&document, &Command::AddPin(nowhere)), EditError::InvalidPin);
    // A caster may have any path that is listed.
    let thrown_by = |bytes: usize| {
        let mut long = pin(BENDY, PinKind::Shadow);
        long.pin.caster = Some("x".repeat(bytes));
        Command::AddPin(long)
    };
    done(&mut document.clone(), &thrown_by(MAX_PATH_BYTES));
    assert!(matches!(refused(&document, &thrown_by(MAX_PATH_BYTES + 1)), EditError::TooLong { .. }));
    for _ in 0..MAX_PINS {
        added(&mut document, BENDY);
    }
    let one_more = Command::AddPin(pin(BENDY, PinKind::Lit));
    assert!(matches!(refused(&document, &one_more), EditError::TooMany { what: "pins", .. }));
}

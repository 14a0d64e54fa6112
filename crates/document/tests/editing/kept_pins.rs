//! Edits of lights with hard pins, in the demo scene.

use std::sync::Arc;

use document::{
    Change, Command, CommandContext, CommandResult, CommandSolution, Document, EditError, LightPin, PinId, checks_pins,
    execute_command, needs_solution, solve_command,
};
use drag::{DragPin, PinKind, PinTarget, WorkBudget};
use glam::DVec3;
use light::parameters::{
    EXPOSURE, LIGHT_LINK, POINT_COLOR, POINT_INTENSITY, POSITION, RADIUS, ROTATION, SCALE, SHADOW_COLOR, SHADOW_ENABLE,
    TRANSLATION,
};
use light::{LightId, Links, SceneBounds};

use crate::features::DEMO;
use crate::support::{done, light_of};

const LIGHT: LightId = LightId(1);

/// Executes a command as a server does: solves it first if it needs that.
fn edited(document: &Document, command: &Command) -> Result<CommandResult, EditError> {
    let work = WorkBudget::new(&|_| true);
    let solve = || solve_command(document, command, SceneBounds::default(), &DEMO.bvh, &work);
    let solved = needs_solution(document, command).then(solve).transpose()?;
    execute_command(document, command, CommandContext { solved: solved.as_ref(), ..CommandContext::default() })
}

fn refused(document: &Document, command: &Command) -> EditError {
    edited(document, command).map(|_| ()).expect_err("a command to refuse")
}

/// Returns a document with the demo's light and a hard pin, on a point of the blue vase that the light reaches.
fn pinned(kind: PinKind) -> (Document, PinId, DVec3) {
    let mut document = Document::default();
    done(&mut document, &Command::AddLight(Arc::clone(&DEMO.light)));
    let origin = DEMO.bvh.posed.origin_in_world;
    let ray = scene::ViewRay::new(&DEMO.view.camera, DEMO.view.size, glam::DVec2::new(165.5, 150.5), origin);
    let at = DEMO.bvh.visible_point(&ray).expect("the blue vase").position + origin;
    let pin = DragPin { kind, at: PinTarget::Point(at), caster: None, is_hard: true };
    done(&mut document, &Command::AddPin(LightPin { light: LIGHT, pin }));
    let (id, _) = document.pins_of(LIGHT).next().expect("a pin");
    (document, id, at)
}

fn drag_point(ignore_pins: bool) -> Command {
    let position = DEMO.light.light().points()[3].position + DVec3::new(0.6, 0.9, -0.3);
    Command::DragPoint { light: LIGHT, point: 3, position, radii_follow: false, ignore_pins }
}

/// Returns the direction from which light arrives at a point.
fn direction(document: &Document, at: DVec3) -> Option<DVec3> {
    let tube = document.lights()[&LIGHT].light.tube().expect("a BendyLight").clone();
    tube.locate(at).point.map(|point| point.direction)
}

/// Angle in degrees by which the direction at a point turns; infinite if the point leaves the light.
fn turned(before: &Document, after: &Document, at: DVec3) -> f64 {
    let began = direction(before, at).expect("inside");
    direction(after, at).map_or(f64::INFINITY, |now| now.angle_between(began).to_degrees())
}

/// Edits that would move the light away from the pinned point are refused with the pin's name, whatever command asks
/// for them. With `ignore_pins`, with a soft pin and without one they are carried out.
///
/// Rules: CMD-18
#[test]
fn edits_that_break_a_hard_pin_are_refused_by_its_name() {
    let (document, pin, _) = pinned(PinKind::Look);
    let away = DVec3::new(40.0, 0.0, 0.0);
    let linked_out = Links::new(Vec::new(), vec!["blue vase".into()]);
    let commands = |ignore_pins: bool| {
        let set_light = |setting| Command::SetLight { light: LIGHT, setting, ignore_pins };
        let set_point = |setting| Command::SetPoint { light: LIGHT, point: 2, setting, ignore_pins };
        vec![
            set_light(TRANSLATION.to(away)),
            set_light(SCALE.to(0.2)),
            set_light(LIGHT_LINK.to(linked_out.clone())),
            set_point(POSITION.to(light_of(&document, LIGHT).points()[2].position + DVec3::new(0.3, 0.3, 0.1))),
            set_point(RADIUS.to(0.7)),
            Command::PlaceLight { light: LIGHT, translation: None, rotation: None, scale: Some(0.2), ignore_pins },
            Command::RemovePoint { light: LIGHT, point: 2, ignore_pins },
            Command::StraightenLight { light: LIGHT, ignore_pins },
        ]
    };
    let mut soft = document.clone();
    done(&mut soft, &Command::SetPin { pin, is_hard: false });
    for (command, ignoring) in commands(false).iter().zip(&commands(true)) {
        let error = refused(&document, command);
        let (light, name) = (document.light_name(LIGHT), document.pin_name(pin));
        assert!(error.to_string().contains(&name) && name.starts_with('“'), "{error}");
        assert_eq!(error, EditError::PinBreaks { light, pin: name }, "{command:?}");
        // Without the pin the same edit is valid, so that it is the pin that refuses it.
        let free = edited(&soft, command).expect("a soft pin refuses nothing");
        let ignored = edited(&document, ignoring).expect("pins are passed over");
        assert!(!free.changes.is_empty());
        assert_eq!(free.changes, ignored.changes, "{command:?}");
        // A solution is needed: without the scene nothing tells if the pin holds.
        let blind = execute_command(&document, command, CommandContext::default()).map(|_| ());
        assert!(matches!(blind, Err(EditError::NotSolved(_))), "{blind:?}");
    }
}

/// Pins have nothing to do with brightness, color and name, so such edits need no solution.
///
/// Rules: CMD-18
#[test]
fn pins_are_of_arrival_and_not_of_amount() {
    let (document, ..) = pinned(PinKind::Look);
    let set_light = |setting| Command::SetLight { light: LIGHT, setting, ignore_pins: false };
    let set_point = |setting| Command::SetPoint { light: LIGHT, point: 2, setting, ignore_pins: false };
    for command in [
        set_light(EXPOSURE.to(-3.0)),
        set_light(SHADOW_COLOR.to(DVec3::ONE)),
        set_light(light::parameters::ENABLED.to(false)),
        set_light(light::parameters::NAME.to("other".into())),
        set_point(POINT_INTENSITY.to(0.0)),
        set_point(POINT_COLOR.to(DVec3::X)),
        Command::RemoveLight(LIGHT),
    ] {
        assert!(!checks_pins(&document, &command), "{command:?}");
        execute_command(&document, &command, CommandContext::default()).expect("carried out");
    }
    // The planted fault: these change where light arrives.
    for command in [set_light(SHADOW_ENABLE.to(false)), set_point(RADIUS.to(0.7))] {
        assert!(checks_pins(&document, &command), "{command:?}");
    }
}

/// A dragged control point slides along the pin; it moves, and the direction at the pinned point stays.
///
/// Rules: CMD-18, CMD-14
#[test]
fn a_dragged_control_point_slides_along_a_pin() {
    let (document, _, at) = pinned(PinKind::Direction);
    let slid = edited(&document, &drag_point(false)).expect("it slides");
    assert!(turned(&document, &slid.document, at) < 1e-3);
    let of_point = |change: &Change| matches!(change, Change::Point { point: 3, .. });
    assert!(!slid.changes.is_empty() && slid.changes.iter().all(of_point), "{:?}", slid.changes);
    let ignored = edited(&document, &drag_point(true)).expect("it moves");
    assert!(turned(&document, &ignored.document, at) > 0.1, "the planted fault: without the pin it turns");
    assert_ne!(slid.changes, ignored.changes);
}

/// A placed light slides along the pin.
///
/// Rules: CMD-18
#[test]
fn a_placed_light_slides_along_a_pin() {
    let (document, _, at) = pinned(PinKind::Direction);
    let from = light_of(&document, LIGHT).get(TRANSLATION);
    let place = |ignore_pins| Command::PlaceLight {
        light: LIGHT,
        translation: Some(from + DVec3::new(0.4, 0.2, 0.3)),
        rotation: Some(light_of(&document, LIGHT).get(ROTATION)),
        scale: None,
        ignore_pins,
    };
    let slid = edited(&document, &place(false)).expect("it slides");
    assert!(turned(&document, &slid.document, at) < 1e-3);
    let moved = light_of(&slid.document, LIGHT).get(TRANSLATION);
    assert!(moved.distance(from) > 0.01, "{moved} {from}");
    let ignored = edited(&document, &place(true)).expect("it moves");
    assert!(turned(&document, &ignored.document, at) > 0.1, "the planted fault: without the pin it turns");
}

/// A pin that does not hold before an edit cannot limit it.
///
/// Rules: CMD-18
#[test]
fn a_pin_that_does_not_hold_limits_nothing() {
    // The point is lit.
    let (document, ..) = pinned(PinKind::Shadowed);
    let away = Command::PlaceLight {
        light: LIGHT,
        translation: Some(DVec3::new(40.0, 0.0, 0.0)),
        rotation: None,
        scale: None,
        ignore_pins: false,
    };
    for command in [away, drag_point(false), Command::StraightenLight { light: LIGHT, ignore_pins: false }] {
        let work = WorkBudget::new(&|_| true);
        let solved = solve_command(&document, &command, SceneBounds::default(), &DEMO.bvh, &work);
        assert_eq!(solved, Ok(CommandSolution::PinsHold), "{command:?}");
        edited(&document, &command).expect("carried out");
    }
    // The planted fault: the pin of a lit point holds.
    let (document, ..) = pinned(PinKind::Lit);
    refused(&document, &Command::SetLight { light: LIGHT, setting: SCALE.to(0.2), ignore_pins: false });
}

/// An edit that is invalid for another reason gives that error, also of a light with pins.
///
/// Rules: CMD-18, CMD-3, CMD-9
#[test]
fn other_errors_come_before_pins() {
    let (document, ..) = pinned(PinKind::Look);
    let remove = Command::RemovePoint { light: LIGHT, point: 99, ignore_pins: false };
    assert!(matches!(refused(&document, &remove), EditError::NoPoint { .. }));
    let negative = Command::SetLight { light: LIGHT, setting: SCALE.to(-1.0), ignore_pins: false };
    assert!(matches!(refused(&document, &negative), EditError::InvalidLight { .. }));
}

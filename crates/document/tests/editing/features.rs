//! Drags of features in the demo scene: their changes, refusals and pins.

use std::sync::{Arc, LazyLock};

use document::{
    Change, Command, CommandContext, CommandResult, CommandSolution, Document, EditError, LightPin, MAX_CHOSEN_POINTS,
    execute_command, solve_drag,
};
use drag::{
    Drag, DragLimit, DragPin, DragRefusal, DragStatus, Feature, PinKind, PinTarget, RadiusMode, SOLVER, Viewport,
};
use glam::{DQuat, DVec2, DVec3};
use light::parameters::{LIGHT_LINK, POSITION, ROTATION, TRANSLATION};
use light::{CheckedLight, LightId, Links};
use raycast::Bvh;

use crate::support::{done, light_of, take_back};

const LIGHT: LightId = LightId(1);

pub struct Demo {
    pub bvh: Bvh,
    pub view: Viewport,
    pub light: Arc<CheckedLight>,
}

pub static DEMO: LazyLock<Demo> = LazyLock::new(|| {
    let demo = assets::demo("vases").expect("it is one of the demos");
    let camera = demo.contents.cameras[0].clone();
    let light = Arc::clone(&demo.contents.lights[0]);
    Demo { bvh: Bvh::new(scene::pose(demo.scene, 0.0)), view: Viewport { camera, size: [640, 360] }, light }
});

/// Returns a document with the demo's light alone.
fn document() -> Document {
    let mut document = Document::default();
    done(&mut document, &Command::AddLight(Arc::clone(&DEMO.light)));
    document
}

/// Returns the drag of the shadow of the blue vase's neck down the table by `down` pixels.
fn shadow(points: Option<Vec<usize>>, down: f64) -> Drag {
    let from = DVec2::new(430.5, 265.5);
    Drag {
        feature: Feature::Shadow,
        points,
        radii: RadiusMode::Keep,
        view: DEMO.view.clone(),
        from,
        to: from + DVec2::new(0.0, down),
        pins: None,
        source_outside: false,
        choice: None,
    }
}

fn dragged(document: &Document, drag: &Drag) -> Result<CommandResult, EditError> {
    let solved = CommandSolution::Drag(Box::new(solve_drag(document, LIGHT, drag, &DEMO.bvh)?));
    let command = Command::DragFeature { light: LIGHT, drag: Box::new(drag.clone()) };
    execute_command(document, &command, CommandContext { solved: Some(&solved), ..CommandContext::default() })
}

/// Returns the lit point where a drag bends the light, so that a slightly violated pin is noticed.
fn a_lit_point(document: &Document) -> DVec3 {
    let light = document.lights()[&LIGHT].light.tube().expect("a BendyLight").clone();
    let origin = DEMO.bvh.posed.origin_in_world;
    let mut seen = (0..640).step_by(20).filter_map(|x| {
        let ray = scene::ViewRay::new(&DEMO.view.camera, DEMO.view.size, DVec2::new(f64::from(x), 330.5), origin);
        DEMO.bvh.visible_point(&ray).map(|seen| seen.position + origin)
    });
    seen.find(|at| light.locate(*at).point.is_some()).expect("the light reaches the picture's lower rows")
}

/// Rules: CMD-15, REC-7
#[test]
fn a_light_that_is_dragged_as_a_whole_is_placed_anew() {
    let before = document();
    let CommandResult { changes, document: after, outcome } = dragged(&before, &shadow(None, 45.0)).expect("it lands");
    let outcome = outcome.expect("a drag has an outcome");
    assert_eq!((outcome.status, (outcome.solver.as_str(), outcome.version)), (DragStatus::Landed, SOLVER));
    assert!(outcome.residual_px <= 0.5 && outcome.pivot_world.is_some());
    let is_placement = |change: &Change| matches!(change, Change::LightParameter { parameter, .. } if *parameter == TRANSLATION.row() || *parameter == ROTATION.row());
    assert!(!changes.is_empty() && changes.iter().all(is_placement), "{changes:?}");
    assert_ne!(before.hash(), after.hash());
    // The changes alone lead there, and back.
    let mut replayed = before.clone();
    replayed.apply(&changes).expect("it fits");
    assert_eq!(replayed.hash(), after.hash());
    take_back(&mut replayed, &changes);
    assert_eq!(replayed.hash(), before.hash());
}

/// Rules: CMD-15, DRAG-3
#[test]
fn a_light_that_is_bent_keeps_all_but_the_points_that_take_part() {
    let before = document();
    let CommandResult { changes, document: after, .. } =
        dragged(&before, &shadow(Some(vec![2, 3, 4]), 45.0)).expect("it lands");
    let is_of_those = |change: &Change| matches!(change, Change::Point { point: 2..=4, parameter, .. } if *parameter == POSITION.row());
    assert!(!changes.is_empty() && changes.iter().all(is_of_those), "{changes:?}");
    assert_eq!(light_of(&after, LIGHT).transform(), light_of(&before, LIGHT).transform());
}

/// The result depends on the document and the cursor: a drag from the end of another drag gives another light.
///
/// Rules: CMD-15, DRAG-2
#[test]
fn the_same_drag_gives_the_same_light() {
    let (before, drag) = (document(), shadow(None, 45.0));
    let [one, two] = [0, 1].map(|_| dragged(&before, &drag).expect("it lands").document.hash());
    assert_eq!(one, two);
    let between = dragged(&before, &shadow(None, 20.0)).expect("it lands").document;
    let on = dragged(&between, &drag).map(|edited| edited.document.hash());
    assert_ne!(on, Ok(one), "the planted fault: another document");
}

/// Rules: CMD-15, DRAG-4, CMD-1
#[test]
fn impossible_drags_are_refused_with_their_reason() {
    let before = document();
    let refused = |drag: &Drag| dragged(&before, drag).map(|_| ()).expect_err("refused");
    let not_dragged = |reason| EditError::DragRefused { light: before.light_name(LIGHT), reason };
    let off = Drag { to: DVec2::new(-50.5, -50.5), ..shadow(None, 0.0) };
    let off = Drag { view: Viewport { camera: sky(), ..off.view.clone() }, ..off };
    assert_eq!(refused(&off), not_dragged(DragRefusal::NothingAtStart));
    assert_eq!(refused(&shadow(Some(vec![0]), 9.0)), not_dragged(DragRefusal::NoSuchPoint));
    // No control point is chosen.
    let nothing_moves = refused(&shadow(Some(vec![]), 9.0));
    assert_eq!(nothing_moves, not_dragged(DragRefusal::NoWeight));
    let said = nothing_moves.to_string();
    assert!(said.contains("no control point that is chosen does anything"), "{said}");
    let lit = Drag { from: DVec2::new(600.5, 300.5), ..shadow(None, 9.0) };
    assert!(matches!(refused(&lit), EditError::DragRefused { .. }));
    let pixelless = Drag { view: Viewport { size: [0, 9], ..DEMO.view.clone() }, ..shadow(None, 9.0) };
    assert_eq!(refused(&pixelless), EditError::EmptyViewport);
    // Values that a record keeps have limits.
    let long = scene::Camera { name: "x".repeat(10_000), ..DEMO.view.camera.clone() };
    let named = Drag { view: Viewport { camera: long, ..DEMO.view.clone() }, ..shadow(None, 9.0) };
    assert!(matches!(refused(&named), EditError::TooLong { field: "name", .. }));
    let listed = |count| shadow(Some(vec![1; count]), 9.0);
    let too_many = refused(&listed(MAX_CHOSEN_POINTS + 1));
    assert_eq!(too_many, EditError::TooManyChosen { what: "control points", limit: MAX_CHOSEN_POINTS });
    assert!(too_many.to_string().starts_with("at most 128 control points can be chosen"), "{too_many}");
    assert!(!matches!(dragged(&before, &listed(MAX_CHOSEN_POINTS)), Err(EditError::TooManyChosen { .. })));
    assert!(refused(&off).to_string().contains("begin on one"), "{}", refused(&off));

    // Without a scene the drag is refused and nothing moves.
    let command = Command::DragFeature { light: LIGHT, drag: Box::new(shadow(None, 9.0)) };
    let error = execute_command(&before, &command, CommandContext::default()).expect_err("refused");
    assert!(matches!(error, EditError::NotSolved(_)));
    let nobodys = Command::DragFeature { light: LightId(9), drag: Box::new(shadow(None, 9.0)) };
    assert!(matches!(
        execute_command(&before, &nobodys, CommandContext::default()),
        Err(EditError::NoLight(LightId(9)))
    ));
}

/// No feature is dragged from a surface that a probe calls unlinked, whatever shadows it.
///
/// Rules: CMD-15, DRAG-4, LINK-2
#[test]
fn nothing_is_dragged_from_a_surface_that_links_leave_out() {
    let linked_but = |left_out: &str| {
        let mut document = document();
        let setting = LIGHT_LINK.to(Links::new(vec![], vec![left_out.into()]));
        done(&mut document, &Command::SetLight { light: LIGHT, setting, ignore_pins: false });
        document
    };
    let before = linked_but("table");
    for points in [None, Some(vec![2, 3, 4])] {
        let error = dragged(&before, &shadow(points.clone(), 45.0)).map(|_| ()).expect_err("unlinked");
        let reason = DragRefusal::OutsideTheLight;
        assert_eq!(error, EditError::DragRefused { light: before.light_name(LIGHT), reason });
        assert!(error.to_string().contains("left out by its links"), "{error}");
        // Deliberate fault that the check must detect: the shadow lies on the table, not on this vase.
        dragged(&linked_but("orange vase"), &shadow(points, 45.0)).expect("it lands");
    }
}

/// Returns the demo camera, turned up.
fn sky() -> scene::Camera {
    let camera = DEMO.view.camera.clone();
    scene::Camera { rotation: DQuat::from_rotation_x(1.5), ..camera }
}

/// Rules: CMD-15, DRAG-5
#[test]
fn pins_of_the_document_hold_and_are_named_by_their_ids() {
    let mut before = document();
    let at = a_lit_point(&before);
    let pin = |kind| DragPin { kind, at: PinTarget::Point(at), caster: None, is_hard: true };
    let add = |kind, light| Command::AddPin(LightPin { light, pin: pin(kind) });
    // Pins of another light do not matter.
    done(&mut before, &Command::AddLight(Arc::clone(&DEMO.light)));
    done(&mut before, &add(PinKind::Shadow, LightId(2)));
    let free = dragged(&before, &shadow(None, 45.0)).expect("it lands");
    assert_eq!(free.outcome.map(|outcome| outcome.status), Some(DragStatus::Landed));

    done(&mut before, &add(PinKind::Direction, LIGHT));
    let (id, _) = before.pins_of(LIGHT).next().expect("a pin");
    let held = dragged(&before, &shadow(Some(vec![1, 2, 3, 4]), 45.0)).expect("as near as may be");
    let direction = |document: &Document| {
        let tube = document.lights()[&LIGHT].light.tube().expect("a BendyLight").clone();
        tube.locate(at).point.map(|point| point.direction)
    };
    let began = direction(&before).expect("inside");
    // Outside the light there is no direction to keep.
    let turned =
        |document: &Document| direction(document).map_or(f64::INFINITY, |now| now.angle_between(began).to_degrees());
    assert!(turned(&free.document) > 0.2, "the planted fault: without the pin it turns");
    assert!(turned(&held.document) < 0.1, "{}", turned(&held.document));
    let status = held.outcome.expect("an outcome").status;
    assert!(status == DragStatus::Landed || status == DragStatus::Limited(DragLimit::Pin(id.0)), "{status:?}");

    // Pin whose condition does not hold.
    done(&mut before, &Command::SetPin { pin: id, is_hard: false });
    done(&mut before, &add(PinKind::Shadowed, LIGHT));
    let (wrong, _) = before.pins_of(LIGHT).last().expect("a pin");
    let error = dragged(&before, &shadow(None, 45.0)).map(|_| ()).expect_err("it does not hold");
    let (light, pin) = (before.light_name(LIGHT), before.pin_name(wrong));
    assert!(
        error.to_string().contains("its pin “In shadow") && !error.to_string().contains(&wrong.to_string()),
        "{error}"
    );
    assert_eq!(error, EditError::PinDoesNotHold { light, pin });
}

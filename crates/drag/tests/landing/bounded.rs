//! Drags that exceed their budget, and drags that are cancelled.

use std::cell::Cell;

use drag::{
    Drag, DragLimit, DragPin, DragRefusal, DragResult, DragStatus, MAX_DRAG_STEPS, NumberedPin, PinKind, PinTarget,
    RadiusMode, STEPS_BETWEEN_CHECKS, WorkBudget, drag_budgeted,
};
use glam::{DVec2, DVec3};
use light::CheckedLight;

use crate::support::{self, TestScene, Trial};

/// Most steps that such a drag spends between two checks of its budget.
const AT_ONCE: u64 = 100_000;

/// Number of pixels that are tried for pins.
const PIXELS: usize = 60;

/// Number of copies of each pin, so that a drag takes some tens of millions of steps.
const TIMES: usize = 7;

/// Makes the demo's drag with pins all over the blue vase, one of them hard.
fn pinned(scene: &TestScene) -> Trial {
    let mut trial = scene.trial_of_the_demo(None);
    let origin = scene.bvh.posed.origin_in_world;
    let pixels = (0..PIXELS).map(|k| DVec2::new(120.5 + 3.0 * (k % 20) as f64, 120.5 + 4.0 * (k / 20) as f64));
    let lit = pixels.filter_map(|pixel| scene.tube_point(&trial.light, pixel));
    let positions: Vec<DVec3> = lit.map(|(seen, _)| seen.position + origin).collect();
    let pin = |(k, at)| DragPin { kind: PinKind::Direction, at: PinTarget::Point(at), caster: None, is_hard: k == 0 };
    trial.pins = positions.repeat(TIMES).into_iter().enumerate().map(pin).collect();
    trial.drag = Drag { points: Some(vec![1, 2, 3, 4]), radii: RadiusMode::Solve, ..trial.drag };
    trial
}

fn run(scene: &TestScene, trial: &Trial, work: &WorkBudget) -> DragResult {
    drag_budgeted(&scene.bvh, &trial.light, &trial.drag, &NumberedPin::by_index(trial.pins.clone()), work)
}

/// True if light arrives at hard pins from the same direction as at the start.
fn hold(trial: &Trial, result: &DragResult) -> bool {
    let after = CheckedLight::new(result.light.clone()).expect("a light that can be evaluated");
    let direction = |light: &CheckedLight, pin: &DragPin| {
        let PinTarget::Point(at) = pin.at else { return None };
        light.tube().and_then(|tube| tube.locate(at).point).map(|point| point.direction)
    };
    trial.pins.iter().filter(|pin| pin.is_hard).all(|pin| {
        let (was, is) = (direction(&trial.light, pin), direction(&after, pin));
        was.zip(is).is_some_and(|(was, is)| was.distance(is) < 1e-5)
    })
}

/// A drag that spends its budget, however small, has a light that holds its hard pins and brings the feature no farther
/// away. It takes at most the limit and the steps between two checks.
///
/// Rules: DRAG-7
#[test]
fn a_drag_over_its_budget_is_limited_and_pins_hold() {
    let scene = support::demo();
    let trial = pinned(&scene);
    let whole = WorkBudget::with_limit(MAX_DRAG_STEPS, &|_| true);
    let landed = run(&scene, &trial, &whole);
    let all = whole.spent_steps();
    println!("{:?} with {} pins takes {all} steps", landed.outcome.status, trial.pins.len());
    assert!(trial.pins.len() > 20 && all > 100 * AT_ONCE, "{all}");
    assert_eq!(landed.outcome.status, DragStatus::Landed);
    assert_eq!(run(&scene, &trial, &WorkBudget::with_limit(all, &|_| true)), landed, "what fits the bound is the same");
    let distance = trial.drag.from.distance(trial.drag.to);
    for share in [0, 1, 2, 4, 8, 12, 15] {
        let most = all * share / 16;
        let work = WorkBudget::with_limit(most, &|_| true);
        let result = run(&scene, &trial, &work);
        println!("{share}/16: {:?}, {} px of {distance} short", result.outcome.status, result.outcome.residual_px);
        let too_much = DragStatus::Refused(DragRefusal::Limited(DragLimit::TooMuchWork));
        assert_eq!((result.outcome.status, &result.light), (too_much, trial.light.light()));
        assert!(result.outcome.residual_px <= distance && hold(&trial, &result), "{result:?}");
        assert!(work.spent_steps() <= most + 2 * AT_ONCE, "{} of {most}", work.spent_steps());
        assert_eq!(result, run(&scene, &trial, &WorkBudget::with_limit(most, &|_| true)), "it is the same each time");
        // Deliberate fault that the check must detect: without the limit the drag takes more.
        assert!(share > 12 || all > most + 2 * AT_ONCE);
    }
}

/// A cancelled drag ends: it checks often if it should continue, and takes hardly a step after the refusal.
#[test]
fn a_cancelled_drag_ends() {
    let scene = support::demo();
    let trial = pinned(&scene);
    let questions = Cell::new(0);
    let goes_on = |_| {
        questions.set(questions.get() + 1);
        questions.get() < 5
    };
    let work = WorkBudget::new(&goes_on);
    run(&scene, &trial, &work);
    assert!(work.is_cancelled());
    assert_eq!(questions.get(), 5, "it is not asked again");
    assert!(work.spent_steps() <= 5 * (STEPS_BETWEEN_CHECKS + AT_ONCE), "{}", work.spent_steps());
    // Deliberate fault that the check must detect: no cancellation.
    let unasked = WorkBudget::new(&|_| true);
    run(&scene, &trial, &unasked);
    assert!(!unasked.is_cancelled() && unasked.spent_steps() > 2 * work.spent_steps());
}

//! A step of the cursor by one pixel moves the light little.

use drag::{Drag, DragChoice, DragResult, Feature, RadiusMode, drag, drag_least_change};
use raycast::SeenPoint;

use crate::support::{self, TestScene, Trial, trials};

/// Longest path of the cursor, in pixels.
const PATH_PX: f64 = 60.0;

/// Change of the light by one pixel, in lengths of the light, that no step exceeds.
const LONG_STEP: f64 = 0.05;

/// Parts of a long step, and the change by one of them that is a jump: a steep way changes the light evenly.
const PARTS: usize = 16;
const JUMP: f64 = 0.02;

/// Least cosine between the normals of neighbouring pixels.
const MIN_NORMALS_COS: f64 = 0.99996;

/// Paths over each scene, of each feature.
const PATHS: usize = 6;
/// The same, of drags by the best alternative.
const PATHS_OF_BEST: usize = 3;

/// Drags to a cursor that goes away from its start pixel by pixel. Stops where the cursor leaves the surface, and where
/// the surface itself turns by more than half a degree a pixel.
fn ends(scene: &TestScene, trial: &Trial, solve: impl Fn(&Drag) -> DragResult) -> Vec<DragResult> {
    let Drag { from, to, .. } = trial.drag;
    let step = (to - from).normalize_or_zero();
    let mut last: Option<SeenPoint> = None;
    let mut ends = Vec::new();
    for px in 0..=PATH_PX.min(from.distance(to)) as usize {
        let to = from + step * px as f64;
        let Some(seen) = scene.seen(to) else { break };
        let is_beside = |last: SeenPoint| {
            last.position.distance(seen.position) < 0.02 * seen.depth && last.normal.dot(seen.normal) > MIN_NORMALS_COS
        };
        if !last.is_none_or(is_beside) {
            break;
        }
        last = Some(seen);
        ends.push(solve(&Drag { to, ..trial.drag.clone() }));
    }
    ends
}

/// Returns the farthest that a control point moves from one light to another, in lengths of the light.
fn change(trial: &Trial, from: &DragResult, to: &DragResult) -> f64 {
    let points = trial.light.light().points();
    let length: f64 = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    let in_world = |result: &DragResult| {
        let transform = result.light.transform();
        result.light.points().iter().map(move |point| transform.world_from_local(point.position)).collect::<Vec<_>>()
    };
    let moved = in_world(from).into_iter().zip(in_world(to)).map(|(from, to)| from.distance(to));
    moved.fold(0.0, f64::max) / length
}

/// True if two drags end alike and relax the same constraints.
fn is_alike(a: &DragResult, b: &DragResult) -> bool {
    let (a, b) = (&a.outcome, &b.outcome);
    let end_alike = std::mem::discriminant(&a.status) == std::mem::discriminant(&b.status);
    end_alike && a.alternative == b.alternative && a.relaxed == b.relaxed
}

/// Returns the farthest that a control point moves by one part of a step of a pixel, in lengths of the light.
fn largest_part(scene: &TestScene, trial: &Trial, px: usize) -> f64 {
    let Drag { from, to, .. } = trial.drag;
    let step = (to - from).normalize_or_zero();
    let at = |part: usize| {
        let to = from + step * (px as f64 + part as f64 / PARTS as f64);
        drag(&scene.bvh, &trial.light, &Drag { to, ..trial.drag.clone() }, &[])
    };
    let parts: Vec<DragResult> = (0..=PARTS).map(at).collect();
    parts.windows(2).map(|pair| change(trial, &pair[0], &pair[1])).fold(0.0, f64::max)
}

/// Number of steps by one pixel between drags that end alike and relax the same constraints, of those that are long, of those
/// that are jumps, and of all others, by which drags end otherwise or relax others.
#[derive(Debug, Default)]
struct Steps {
    all: usize,
    long: usize,
    jumps: usize,
    between: usize,
}

/// Steps of drags of what the trials name, or of the best alternative, as a page drags.
fn steps_over(scene: &TestScene, choice: Option<DragChoice>) -> Steps {
    let mut steps = Steps::default();
    let paths = if choice.is_none() { PATHS } else { PATHS_OF_BEST };
    for feature in [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse] {
        for mut trial in trials(scene, feature, 2 * PATHS).filter(|trial| !trial.is_there_already()).take(paths) {
            trial.drag.radii = RadiusMode::Follow;
            trial.drag.source_outside = true;
            if choice.is_some() {
                trial.drag.points = None;
                trial.drag.choice = choice;
            }
            let ends = ends(scene, &trial, |to| drag(&scene.bvh, &trial.light, to, &[]));
            for (px, pair) in ends.windows(2).enumerate() {
                let size = change(&trial, &pair[0], &pair[1]);
                if !is_alike(&pair[0], &pair[1]) {
                    steps.between += 1;
                    continue;
                }
                steps.all += 1;
                if size > LONG_STEP {
                    let part = largest_part(scene, &trial, px);
                    steps.long += 1;
                    steps.jumps += usize::from(part > JUMP);
                    let points = trial.drag.points.as_ref().map_or(0, Vec::len);
                    println!(
                        "{} {feature:?} of {points} points at {px} px: {size:.3}, {part:.3} by a part",
                        scene.name
                    );
                }
            }
        }
    }
    steps
}

fn steps_over_scenes(choice: Option<DragChoice>) -> Steps {
    let scenes = support::scenes();
    let counts: Vec<Steps> = std::thread::scope(|threads| {
        let running: Vec<_> = scenes.iter().map(|scene| threads.spawn(|| steps_over(scene, choice))).collect();
        running.into_iter().map(|thread| thread.join().expect("no drag panics")).collect()
    });
    let sum = |of: fn(&Steps) -> usize| counts.iter().map(of).sum::<usize>();
    let sum = Steps {
        all: sum(|steps| steps.all),
        long: sum(|steps| steps.long),
        jumps: sum(|steps| steps.jumps),
        between: sum(|steps| steps.between),
    };
    println!("{sum:?}");
    sum
}

/// No step is long, but where the answer names another end, alternative or relaxed constraint.
///
/// Rules: DRAG-3
#[test]
fn a_pixel_moves_the_light_little() {
    let steps = steps_over_scenes(None);
    assert!(steps.all > 1000 && 10 * steps.between < steps.all && steps.long == 0, "{steps:?}");
}

/// The same of the best alternative, while it stays the same one.
#[test]
fn a_pixel_moves_the_best_alternative_little() {
    let steps = steps_over_scenes(Some(DragChoice::Best));
    assert!(steps.all > 500 && 10 * steps.between < steps.all && steps.long == 0, "{steps:?}");
}

/// The planted fault: a solver that moves control points least jumps.
#[test]
fn the_least_change_jumps() {
    let scene = support::demo();
    let mut long = 0;
    for trial in trials(&scene, Feature::Shadow, 4 * PATHS).filter(|trial| !trial.is_there_already()) {
        let ends = ends(&scene, &trial, |drag| drag_least_change(&scene.bvh, &trial.light, drag));
        long += ends
            .windows(2)
            .filter(|pair| is_alike(&pair[0], &pair[1]) && change(&trial, &pair[0], &pair[1]) > LONG_STEP)
            .count();
    }
    assert!(long > 0, "{long}");
}

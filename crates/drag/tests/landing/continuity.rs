//! A small step of the cursor moves the light little.

use drag::{Drag, DragStatus, Feature, drag};
use glam::DVec3;

use crate::support::{self, TestScene, Trial, trials};

/// Steps of a cursor path.
const STEPS: usize = 500;

/// Lights that result from a cursor path.
struct Path {
    /// Picked surface point at each cursor position.
    picked: Vec<DVec3>,
    /// Direction at the picked point in which the light must arrive: the normal, or the mirror direction to the eye.
    targets: Vec<DVec3>,
    /// Control points in the world.
    points: Vec<Vec<DVec3>>,
}

/// Drags along a cursor path. `None` if a part of it is off the surfaces.
fn path(scene: &TestScene, trial: &Trial) -> Option<Path> {
    let mut path = Path { picked: Vec::new(), targets: Vec::new(), points: Vec::new() };
    for step in 0..=STEPS {
        let to = trial.drag.from.lerp(trial.drag.to, step as f64 / STEPS as f64);
        let result = drag(&scene.bvh, &trial.light, &Drag { to, ..trial.drag.clone() }, &[]);
        if matches!(result.outcome.status, DragStatus::Refused(_)) {
            return None;
        }
        let seen = scene.seen(to)?;
        path.picked.push(result.outcome.to_world?);
        path.targets.push(if trial.drag.feature == Feature::Highlight { seen.mirror_direction() } else { seen.normal });
        let transform = result.light.transform();
        let in_world = result.light.points().iter().map(|point| transform.world_from_local(point.position));
        path.points.push(in_world.collect());
    }
    Some(path)
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn steps(positions: &[DVec3]) -> Vec<f64> {
    positions.windows(2).map(|pair| pair[0].distance(pair[1])).collect()
}

impl Path {
    /// Measures the largest step of a control point in medians of all steps, and the length of its path as a multiple
    /// of the distance between its ends.
    ///
    /// Only cursor steps at which the picked point moves evenly count: neither its step nor that of the required
    /// direction is above 3 of its medians.
    fn largest_step_and_detour(&self, feature: Feature) -> Option<(f64, f64)> {
        let (picks, turns) = (steps(&self.picked), steps(&self.targets));
        let (pick, turn) = (median(&picks), median(&turns).max(1e-4));
        let is_turned = matches!(feature, Feature::Highlight | Feature::Diffuse);
        let counts = |k: usize| picks[k] < 3.0 * pick && (!is_turned || turns[k] < 3.0 * turn);
        let of_point = |point: usize| steps(&self.points.iter().map(|all| all[point]).collect::<Vec<_>>());
        let each: Vec<Vec<f64>> = (0..self.points[0].len()).map(of_point).collect();
        let largest = |k: usize| each.iter().map(|steps| steps[k]).fold(0.0, f64::max);
        let all: Vec<f64> = (0..STEPS).map(largest).collect();
        let worst = (0..STEPS).filter(|k| counts(*k)).map(|k| all[k]).fold(0.0, f64::max);
        let is_even = (0..STEPS).all(counts);
        let detour = |(point, steps): (usize, &Vec<f64>)| {
            let across = self.points[0][point].distance(self.points[STEPS][point]);
            if across > 0.0 { steps.iter().sum::<f64>() / across } else { 0.0 }
        };
        let detour = each.iter().enumerate().map(detour).fold(0.0, f64::max);
        let typical = median(&all);
        (typical > 0.0).then(|| (worst / typical, if is_even { detour } else { 1.0 }))
    }
}

/// Numbers of the smooth and of the other cursor paths over a scene.
///
/// A smooth path has no step above 20 medians and is less than 8 times as long as the distance between its ends.
fn paths_over(scene: &TestScene) -> [usize; 2] {
    let mut counts = [0; 2];
    for feature in [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse] {
        for trial in trials(scene, feature, 4).filter(|trial| !trial.is_there_already()) {
            let Some(path) = path(scene, &trial) else { continue };
            let Some((largest, detour)) = path.largest_step_and_detour(feature) else { continue };
            counts[usize::from(largest >= 20.0 || detour >= 8.0)] += 1;
            let (name, points) = (&scene.name, &trial.drag.points);
            println!("{name} {feature:?} {points:?}: {largest:.1} medians, {detour:.1} times as long");
        }
    }
    counts
}

/// Nearly all paths are smooth. The others reach a point past which the light cannot go on evenly, and the drag jumps
/// for one cursor position and slides for the next.
#[test]
fn a_small_step_of_the_cursor_moves_the_light_little() {
    let scenes = support::scenes();
    let counts: Vec<[usize; 2]> = std::thread::scope(|threads| {
        let running: Vec<_> = scenes.iter().take(2).map(|scene| threads.spawn(|| paths_over(scene))).collect();
        running.into_iter().map(|thread| thread.join().expect("no drag panics")).collect()
    });
    let [smooth, rough] = [0, 1].map(|which| counts.iter().map(|counts| counts[which]).sum::<usize>());
    println!("{smooth} smooth, {rough} not");
    assert!(smooth >= 9 * rough && smooth > 10, "{smooth} smooth, {rough} not");
}

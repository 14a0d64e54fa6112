//! Distant parts of a tube do not meet in a slide or a drag.

use drag::{Drag, DragLimit, DragStatus, Feature, RadiusMode, slide_point};
use glam::{DVec2, DVec3};
use light::parameters::{ALLOW_OVERLAP, TRANSLATION};
use light::{CheckedLight, Light, Tube};

use crate::sliding::directions;
use crate::support::{self, TestScene};

/// Makes a light whose last arm comes back beside its first.
fn hook() -> CheckedLight {
    let points = [[0.0, 0.0], [0.0, -2.0], [0.0, -4.0], [1.5, -5.5], [3.0, -4.0], [3.0, -2.0], [3.0, 0.0]];
    let points = points.map(|[x, z]| DVec3::new(x, 0.0, z));
    CheckedLight::new(Light::bendy(points.into(), vec![0.1, 0.4, 0.5, 0.5, 0.5, 0.5, 0.5])).expect("valid")
}

/// Makes a light whose first arm goes over the ground, and whose last one comes back above and goes down beside it.
fn loop_over_ground() -> CheckedLight {
    let points = [
        [-6.0, 1.2, 0.0],
        [-2.0, 1.2, 0.0],
        [3.0, 1.2, 0.0],
        [5.5, 2.6, 0.0],
        [3.0, 4.4, 0.0],
        [0.0, 4.4, 1.0],
        [-1.5, 2.6, 2.4],
        [-1.5, -4.0, 2.4],
    ];
    let points: Vec<DVec3> = points.map(|point| DVec3::from(point) - DVec3::new(-6.0, 1.2, 0.0)).into();
    let light = Light::bendy(points, vec![0.1, 0.3, 0.4, 0.5, 0.6, 0.6, 0.6, 0.6]);
    CheckedLight::new(light.with(TRANSLATION, DVec3::new(-6.0, 1.2, 0.0))).expect("valid")
}

/// Returns the greatest depth, in radii, of points of one part of a tube within another. It tests 40 points around each
/// of 200 cross-sections a segment against all others, by the plane and the radius of each.
fn overlap_depth(tube: &Tube<f64>) -> f64 {
    const ALONG: usize = 200;
    let sections: Vec<(f64, DVec3, DVec3, f64)> = (0..tube.n * ALONG)
        .map(|k| {
            let (curve, u) = (&tube.segments[k / ALONG].curve, (k % ALONG) as f64 / ALONG as f64);
            (k as f64 / ALONG as f64, curve.position(u), curve.d(u).normalize(), curve.radius(u))
        })
        .collect();
    let mut deepest = 0.0_f64;
    for (t, center, tangent, radius) in sections.iter().step_by(4) {
        let right = tangent.any_orthonormal_vector();
        let up = tangent.cross(right);
        for around in 0..40 {
            let angle = std::f64::consts::TAU * f64::from(around) / 40.0;
            let point = *center + (right * libm::cos(angle) + up * libm::sin(angle)) * *radius;
            for pair in sections.windows(2).filter(|pair| (pair[0].0 - t).abs() > 1.0) {
                let [side, next] = [&pair[0], &pair[1]].map(|(_, center, tangent, _)| (point - *center).dot(*tangent));
                let inside = 1.0 - point.distance(pair[0].1) / pair[0].3;
                if side >= 0.0 && next < 0.0 {
                    deepest = deepest.max(inside);
                }
            }
        }
    }
    deepest
}

fn overlapping(light: &CheckedLight) -> CheckedLight {
    CheckedLight::new(light.light().clone().with(ALLOW_OVERLAP, true)).expect("valid")
}

/// The end of the hook, dragged through the first arm, stops at it and slides along it. Without the rule it goes through.
#[test]
fn control_points_stop_where_the_tube_would_meet_itself() {
    let light = hook();
    let from = light.light().points()[6].position;
    let mut crossed = 0;
    for direction in directions() {
        let to = DVec3::new(0.0, 0.0, -1.0) + direction * 0.8;
        let slide = slide_point(&light, 6, to, RadiusMode::Keep).expect("a control point");
        let free = slide_point(&overlapping(&light), 6, to, RadiusMode::Keep).expect("a control point");
        let depths = [&slide, &free].map(|slide| overlap_depth(slide.light.tube().expect("bent")));
        println!("{direction:.2} {:?} {:?} {:.3} {depths:.3?}", slide.limit, free.limit, slide.distance_left);
        assert!(depths[0] == 0.0, "{direction} {depths:?}");
        // Deliberate fault that the check must detect: a light that may overlap.
        let is_limited = slide.limit == Some(DragLimit::Overlap);
        assert!(is_limited || depths[1] == 0.0, "{direction} {depths:?}");
        crossed += usize::from(depths[1] > 0.05);
        // Nearer than where the straight way meets the arm, which is 0.5 of a radius and some of its clearance from it.
        let position = slide.light.light().points()[6].position;
        assert!(position.distance(to) < 0.7 * from.distance(to), "{direction} {position} {to}");
    }
    assert!(crossed > 5, "{crossed}");
}

/// A light that overlaps before it is edited goes on to.
#[test]
fn a_light_that_overlaps_may_go_on_to() {
    let to = DVec3::new(0.0, 0.0, -1.0);
    let crossed = slide_point(&overlapping(&hook()), 6, to, RadiusMode::Keep).expect("a control point").light;
    let crossed = CheckedLight::new(crossed.light().clone().with(ALLOW_OVERLAP, false)).expect("valid");
    let beside = slide_point(&crossed, 6, to + DVec3::new(0.01, 0.0, 0.0), RadiusMode::Keep).expect("a control point");
    assert_eq!(beside.limit, None);
}

/// Cursors on a circle through both arms, in 300 steps: no step of the control point exceeds a few of the cursor's.
#[test]
fn sliding_along_an_arm_is_smooth() {
    let light = hook();
    let mut before: Option<DVec3> = None;
    let mut steps: Vec<f64> = Vec::new();
    for step in 0..=300 {
        let angle = std::f64::consts::TAU * f64::from(step) / 300.0;
        let to = DVec3::new(1.5 + 1.5 * libm::cos(angle), libm::sin(angle), 0.0);
        let slide = slide_point(&light, 6, to, RadiusMode::Keep).expect("a control point");
        let position = slide.light.light().points()[6].position;
        steps.extend(before.map(|before| before.distance(position)));
        before = Some(position);
    }
    steps.sort_by(f64::total_cmp);
    println!("median {} largest {:?}", steps[150], &steps[290..]);
    assert!(steps[299] < 20.0 * steps[150], "{:?}", &steps[280..]);
}

/// The pool of the loop's end, dragged along the ground below its first arm, ends before the arm or goes around it. With
/// overlaps allowed it goes through.
#[test]
fn features_stop_where_the_tube_would_meet_itself() {
    let scene = support::ground();
    let light = loop_over_ground();
    let at = |x: f64, z: f64| pixel_of(&scene, DVec3::new(x, 0.0, z));
    let mut met = 0;
    for k in 0..6 {
        let drag = Drag {
            feature: Feature::Hotspot,
            points: Some(vec![6, 7]),
            radii: RadiusMode::Keep,
            view: scene.view.clone(),
            from: at(-1.5, 2.3),
            to: at(-2.0 + 0.4 * f64::from(k), 0.0),
            pins: None,
            source_outside: false,
            choice: None,
        };
        let [kept, free] = [light.clone(), overlapping(&light)].map(|light| drag::drag(&scene.bvh, &light, &drag, &[]));
        let depths = [&kept, &free].map(|result| {
            let light = CheckedLight::new(result.light.clone()).expect("valid");
            overlap_depth(light.tube().expect("bent"))
        });
        println!("{k} {:?} {:?} {depths:.3?}", kept.outcome.status, free.outcome.status);
        assert!(depths[0] < 0.01, "{k} {depths:?}");
        let is_limited = kept.outcome.status != DragStatus::Landed;
        met += usize::from(free.outcome.status == DragStatus::Landed && depths[1] > 0.05);
        assert!(!is_limited || depths[1] > 0.0 || free.outcome.status != DragStatus::Landed, "{k} {depths:?}");
    }
    assert!(met > 2, "the drags that the rule stops overlap without it: {met}");
}

fn pixel_of(scene: &TestScene, point_in_world: DVec3) -> DVec2 {
    let view = &scene.view;
    let origin = scene.bvh.posed.origin_in_world;
    scene::pixel_of(&view.camera, view.size, point_in_world - origin, origin).expect("in the picture")
}

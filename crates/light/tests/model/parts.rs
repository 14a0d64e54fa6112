//! The part of a light near a scene is the same light there, and f32 holds it.

use glam::{DQuat, DVec3};
use light::parameters::{DECAY, END_MODE, FRAME, ROTATION, TRANSLATION};
use light::{Decay, EndMode, FrameMode, Light, Tube, TubeLocation};

/// Returns lights `size` units long that pass the origin bent, 3 units wide there: at the middle of a segment, over a
/// joint, over their end and past it.
fn lights(size: f64) -> Vec<Light> {
    let (along, aside) = (DVec3::new(0.6, -0.64, 0.48), DVec3::new(0.8, 0.48, -0.36));
    let points = [DVec3::ZERO, along * 0.3, along * 0.5 + aside * 0.1, along * 0.6 + aside * 0.3, aside * 0.6];
    let mut lights = Vec::new();
    for (end_mode, t) in [
        (EndMode::Cut, 0.5),
        (EndMode::Cut, 1.0),
        (EndMode::Cut, 2.75),
        (EndMode::Extend, 3.0),
        (EndMode::Extend, 3.25),
    ] {
        for frame in [FrameMode::RotationMinimizing, FrameMode::Up] {
            let mut light = Light::bendy(points.map(|point| point * size).into(), vec![3.0; 5])
                .with(END_MODE, end_mode)
                .with(FRAME, frame)
                .with(DECAY, Decay::InverseSquare)
                .map_points(|i, point| point.color = DVec3::splat([1.0, 0.5, 0.25, 2.0, 1.0][i]));
            light.set(ROTATION.to(DQuat::from_xyzw(0.1, -0.5, 0.3, 0.8).normalize()));
            let tube = Tube::new(&light).expect("a light");
            let (segment, u) = tube.segment_at(t);
            let at = tube.placement.world_from_tube(tube.segments[segment].curve.position(u));
            light.set(TRANSLATION.to(-at));
            lights.push(light);
        }
    }
    lights
}

/// Returns points of a scene 4 units wide around the origin.
fn scene() -> Vec<DVec3> {
    (0..125).map(|k| DVec3::new(f64::from(k % 5), f64::from(k / 5 % 5), f64::from(k / 25)) - 2.0).collect()
}

/// Returns the distance in world units, along or across the light, between two locations of a point; `None` if one is
/// outside.
fn world_distance(tube: &Tube<f64>, a: &TubeLocation, b: &TubeLocation) -> Option<f64> {
    let (a, b) = (a.point.as_ref()?, b.point.as_ref()?);
    let speed = 2.0 * tube.segments[b.segment].curve.d(b.u).length() * tube.placement.world_per_tube;
    let across = DVec3::new(a.v - b.v, a.w - b.w, 0.0).length() * b.radius;
    Some(((a.t - b.t) * speed).abs().max(across))
}

fn max_world_distance(tube: &Tube<f64>, points: &[DVec3], locate: impl Fn(DVec3) -> TubeLocation) -> f64 {
    let mut worst = 0.0_f64;
    let mut inside = 0;
    for &point in points {
        let (found, exact) = (locate(point), tube.locate(point));
        assert_eq!(found.roots.len(), exact.roots.len(), "{point}: {found:?} {exact:?}");
        if let Some(apart) = world_distance(tube, &found, &exact) {
            worst = worst.max(apart);
            inside += 1;
        }
    }
    assert!(inside > 20, "{inside}");
    worst
}

/// In f64 the part agrees with the light to the rounding of the light's length.
#[test]
fn a_part_equals_the_light_in_its_box() {
    for size in [1e3, 1e4, 1e6] {
        for light in lights(size) {
            let tube = Tube::new(&light).expect("a light");
            let part = tube.part_near(DVec3::ZERO, DVec3::splat(2.0));
            assert!(part.t_span <= 0.0625 && part.tube.n <= 2, "{size:e}: {} of {}", part.t_span, part.tube.n);
            let off = max_world_distance(&tube, &scene(), |point| part.to_whole_light(&part.tube.locate(point)));
            assert!(off <= 1e-13 * size, "{size:e}: {off:e}");
            for point in scene() {
                let irradiance = |tube: &Tube<f64>| {
                    let root = tube.nearest_root(tube.placement.tube_from_world(point))?;
                    Some((tube.irradiance(&root), tube.direction_at(&root).normalize()))
                };
                let (Some(whole), Some(there)) = (irradiance(&tube), irradiance(&part.tube)) else {
                    continue;
                };
                // Arc lengths are exact to 5e-8 (see arc.rs), and decay takes their square. Positions round to 1e-13 of
                // the size, over which the profile changes by less than ten times that. Light comes from 0.2 sizes or
                // more.
                let bound = 1e-7 * whole.0.length() + 1e-12 * size * 2.0 / (0.2 * size).powi(2);
                assert!(whole.0.distance(there.0) <= bound, "{whole:?} {there:?}");
                assert!(whole.1.distance(there.1) < 1e-9, "{whole:?} {there:?}");
            }
        }
    }
}

/// f32 holds positions in a scene that is a ten-thousandth or a millionth of the light, to a few roundings of the scene
/// and of the tube's width there.
#[test]
fn f32_holds_a_small_scene() {
    for size in [1e3, 1e4, 1e6] {
        let (mut before, mut after) = (0.0_f64, 0.0_f64);
        for light in lights(size) {
            let tube = Tube::new(&light).expect("a light");
            let whole = Tube::<f32>::from(&tube);
            let points = scene();
            let part = tube.part_near_points(&points);
            let part_f32 = Tube::<f32>::from(&part.tube);
            after = after.max(max_world_distance(&tube, &points, |point| part.to_whole_light(&part_f32.locate(point))));
            // Deliberate fault that the check must detect: the light as a whole.
            for &point in &points {
                let (found, exact) = (whole.locate(point), tube.locate(point));
                before = before.max(world_distance(&tube, &found, &exact).unwrap_or(0.0));
            }
        }
        println!("{size:e} units: off by {:.1e} of a scene of 4 units, whole {:.1e}", after / 4.0, before / 4.0);
        // Sixteen roundings of some ten units: of the scene and of the radius.
        assert!(after <= 16.0 * 10.0 * 2.0_f64.powi(-24), "{size:e}: {after:e}");
        assert!(before > 10.0 * after, "{size:e}: {before:e}");
    }
}

/// A light that is not much longer than the box, or does not come near it, stays whole.
#[test]
fn a_short_or_distant_light_stays_whole() {
    let light = Light::bendy(vec![DVec3::ZERO, DVec3::NEG_Z, DVec3::new(1.0, 0.0, -2.0)], vec![0.1, 0.4, 0.8]);
    let tube = Tube::new(&light).expect("a light");
    for (center, half) in [(DVec3::NEG_Z, 1.0), (DVec3::NEG_Z, 0.2), (DVec3::X * 50.0, 1.0), (DVec3::ZERO, 0.0)] {
        let part = tube.part_near(center, DVec3::splat(half));
        let is_whole = part.t_span == 1.0 && part.tube.n == tube.n && part.t_start == 0.0;
        assert_eq!(is_whole, half > 0.0, "{center} {half}");
    }
    assert_eq!(tube.part_near_points(&[]).tube.n, tube.n);
}

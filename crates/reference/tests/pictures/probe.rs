//! Tests of probes, against closed forms and against pictures. Each state has a test with and without its
//! cause.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use light::parameters::{
    CONE_ANGLE, CUT_OFF, DIFFUSE, ENABLED, FAR_EDGE, HEIGHT, INTENSITY, LIGHT_LINK, RANGE, ROTATION, SHADOW_COLOR,
    SHADOW_ENABLE, SHADOW_LINK, SPECULAR, TRANSLATION, WIDTH,
};
use light::{Light, LightId, Links};
use raycast::Bvh;
use reference::{DisabledBy, LightProbe, LightState, Probe, ProbedCaster, Reference, ReferenceError};
use scene::{Aov, Image, Sampler, Scene, TextureRef, View, Wrap};

use crate::support::{ball_over_floor, centres, floor, instances, looking, render, scene_of, spot, view};

fn for_points(scene: &Scene) -> Reference {
    Reference::for_point_queries(Arc::new(Bvh::new(scene::pose(scene.clone(), 0.0))))
}

/// Probes the middle of a picture.
fn probe_middle(reference: &Reference, view: &View, lights: &[Light]) -> Probe {
    let middle = DVec2::new(24.0, 16.0);
    reference.probe(view, middle, &instances(lights), &BTreeSet::new()).expect("a pixel of the picture")
}

/// Probes the middle of a picture, which shows the middle of the floor under the ball.
fn under_the_ball(light: &Light) -> LightProbe {
    let view = view(DVec3::new(3.0, 1.5, 0.0), DVec3::ZERO, Aov::Beauty);
    let Probe { seen, mut lights } = probe_middle(&for_points(&ball_over_floor()), &view, std::slice::from_ref(light));
    let seen = seen.expect("the floor");
    assert!(seen.node == 0 && seen.position.length() < 1e-12 && (seen.normal - DVec3::Y).length() < 1e-12);
    lights.pop().expect("the light")
}

/// Returns a light of each shape, from straight above.
fn from_above() -> [Light; 4] {
    let above = DVec3::new(0.0, 3.0, 0.0);
    let lamp = spot(above, DVec3::ZERO).with(RANGE, None);
    let down = looking(above, DVec3::ZERO);
    [
        light::bend(&lamp.clone().with(RANGE, Some(6.0)), 3).expect("a cone"),
        lamp,
        Light::omni().with(TRANSLATION, above),
        Light::directional()
            .with(TRANSLATION, above)
            .with(ROTATION, down)
            .with(WIDTH, Some(2.0))
            .with(HEIGHT, Some(2.0)),
    ]
}

/// Each state occurs with its cause. Without the cause the light is lit.
///
/// Rules: PROBE-2
#[test]
fn each_state_has_its_cause_and_goes_with_it() {
    for shadowed in from_above() {
        // The first occluder is the top of the ball, where a vertex of the mesh lies exactly.
        let LightState::Shadowed(ProbedCaster { node, position }) = under_the_ball(&shadowed).state else {
            panic!("{shadowed:?}")
        };
        assert!(node == 1 && position.distance(DVec3::Y * 1.4) < 1e-9, "{position}");
        let exclude = |name: &str| Links::new(Vec::new(), vec![name.into()]);
        let lit = shadowed.clone().with(SHADOW_LINK, exclude("ball"));
        for lit in [&lit, &shadowed.clone().with(SHADOW_ENABLE, false)] {
            assert_eq!(under_the_ball(lit).state, LightState::Lit, "{lit:?}");
        }
        let off = under_the_ball(&lit.clone().with(ENABLED, false));
        assert_eq!(off.state, LightState::Disabled(DisabledBy::Off));
        for dark in [lit.clone().with(INTENSITY, 0.0), lit.clone().with(DIFFUSE, 0.0).with(SPECULAR, 0.0)] {
            assert_eq!(under_the_ball(&dark).state, LightState::Disabled(DisabledBy::Dark));
        }
        let unlinked = under_the_ball(&lit.clone().with(LIGHT_LINK, exclude("floor")));
        assert_eq!(unlinked.state, LightState::Unlinked);
        // A light that does not shine has coordinates too, but no irradiance.
        for probe in [off, unlinked] {
            assert!(probe.place.is_some() && probe.path.len() >= 2);
            assert_eq!((probe.irradiance, probe.radiance, probe.share), (DVec3::ZERO, DVec3::ZERO, 0.0));
        }
        // From below, the light would pass through the floor.
        let below = lit.clone().with(TRANSLATION, DVec3::Y * -3.0).with(ROTATION, looking(DVec3::NEG_Y, DVec3::ZERO));
        let facing = under_the_ball(&below);
        assert_eq!((facing.state, facing.radiance), (LightState::FacingAway, DVec3::ZERO), "{below:?}");
        let mut aside = lit.clone().with(TRANSLATION, DVec3::new(4.0, 3.0, 0.0));
        if aside.value(&CONE_ANGLE).is_none() && aside.value(&RANGE).is_some() {
            aside = aside.with(RANGE, Some(1.0));
        }
        let outside = under_the_ball(&aside);
        assert_eq!(outside.state, LightState::Outside, "{aside:?}");
        assert!(outside.place.is_none() && outside.path.is_empty());
    }
    let faded = from_above()[1].clone().with(CUT_OFF, Some(1.0)).with(FAR_EDGE, 0.5);
    assert_eq!(under_the_ball(&faded).state, LightState::Faded);
    assert_ne!(under_the_ball(&faded.with(CUT_OFF, Some(2.9))).state, LightState::Faded);
}

/// Coordinates of straight lights follow from geometry, whatever their shape.
///
/// Rules: PROBE-3, PROBE-4
#[test]
fn a_straight_light_has_the_closed_form() {
    let (source, point) = (DVec3::new(0.6, 3.0, -0.8), DVec3::new(0.25, 0.0, 0.5));
    let lamp = spot(source, DVec3::ZERO).with(RANGE, Some(6.0));
    let view = view(DVec3::new(1.0, 3.0, 2.0), point, Aov::Beauty);
    let omni = Light::omni().with(TRANSLATION, source);
    let lights = [lamp.clone(), light::bend(&lamp, 3).expect("a cone"), omni];
    let reference = for_points(&scene_of([floor(3.0)]));
    let probe = probe_middle(&reference, &view, &lights);
    let to_source = source - point;
    let axis = -source.normalize();
    let depth = -to_source.dot(axis);
    let radius = depth * 25.0_f64.to_radians().tan();
    // The tolerance is some ulps of lengths of about 4.
    let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
    for (index, light) in probe.lights.iter().enumerate() {
        let place = light.place.expect("inside");
        assert_eq!(light.state, LightState::Lit);
        assert!(near(place.path_length.expect("from somewhere"), to_source.length()), "{index}: {place:?}");
        assert!(place.coords.direction.distance(to_source.normalize()) < 1e-12, "{index}");
        let [first, .., last] = light.path[..] else { panic!("a line") };
        assert!(first.distance(source) < 1e-12 && last.distance(point) < 1e-12, "{index}: {:?}", light.path);
        // All points in between lie on the line.
        let off = |at: &DVec3| (*at - source).cross(to_source).length() / to_source.length();
        assert!(light.path.iter().all(|at| off(at) < 1e-12));
        match place.radius {
            Some(found) => {
                assert!(near(found, radius), "{index}: {found} {radius}");
                let across = (-to_source - axis * depth).length() / radius;
                assert!(near(libm::hypot(place.coords.v, place.coords.w), across), "{index}");
            }
            None => assert_eq!(index, 2, "only an omni light has none"),
        }
    }
    // Deliberate fault that the check must detect: the light is moved sideways by a thousandth.
    let moved = probe_middle(&reference, &view, &[lamp.with(TRANSLATION, source + DVec3::X * 1e-3)]);
    let length = moved.lights[0].place.and_then(|place| place.path_length).expect("inside");
    assert!(!near(length, to_source.length()));
}

/// The path of a bent light lies on its curve, from the source to the surface, and meets its occluder.
///
/// Rules: PROBE-2, PROBE-4
#[test]
fn the_path_of_a_bent_light_is_drawn_and_measured() {
    let points = [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.5, 0.0, -2.0], [0.0, 0.0, -3.0], [0.0, 0.0, -4.0]];
    let radii = vec![0.1, 0.3, 0.4, 0.5, 0.6];
    let above = DVec3::new(-0.1, 3.5, 0.1);
    let light = Light::bendy(points.map(DVec3::from).into(), radii)
        .with(TRANSLATION, above)
        .with(ROTATION, looking(above, DVec3::new(-0.1, 0.0, 0.1)));
    let probe = under_the_ball(&light);
    let tube = light::Tube::<f64>::new(&light).expect("a tube");
    let place = probe.place.expect("inside");
    let (t, v, w) = (place.coords.t, place.coords.v, place.coords.w);
    let found = tube.locate(DVec3::ZERO).point.expect("inside");
    assert!((found.t - t).abs() < 1e-12 && (found.radius - place.radius.expect("a tube")).abs() < 1e-12);
    let path = raycast::BentPath::new(&tube, v, w, DVec3::ZERO);
    let at = |t: f64| {
        let segment = (t as usize).min(tube.n - 1);
        path.position_at(segment, t - segment as f64)
    };
    let steps = 100_000;
    let point = |k: i32| at(t * f64::from(k) / f64::from(steps));
    let walked: f64 = (0..steps).map(|k| point(k).distance(point(k + 1))).sum();
    let length = place.path_length.expect("from somewhere");
    // The sum of chords has a relative error of (h kappa)^2 / 24 with 1e5 steps.
    assert!((length / walked - 1.0).abs() < 1e-8, "{length} {walked}");
    assert!(probe.path.len() <= 256 && probe.path[0].distance(at(0.0)) < 1e-12);
    assert!(probe.path.last().expect("an end").length() < 1e-12);
    let off_path = |point: DVec3| {
        let pieces = probe.path.windows(2).map(|piece| {
            let along = piece[1] - piece[0];
            let share = ((point - piece[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
            point.distance(piece[0] + along * share)
        });
        pieces.fold(f64::INFINITY, f64::min)
    };
    for k in 0..=1000 {
        assert!(off_path(at(t * f64::from(k) / 1000.0)) < length / 4096.0, "{k}");
    }
    // The floor is flat, so the occluder lies on the light path itself.
    let LightState::Shadowed(ProbedCaster { node: 1, position }) = probe.state else { panic!("{:?}", probe.state) };
    assert!(off_path(position) < length / 4096.0);
    // Deliberate faults that the check must detect: the straight line is not the light path, and has another length.
    assert!(off_path(above.lerp(DVec3::ZERO, 0.5)) > length / 100.0);
    assert!(above.length() < 0.99 * length);
}

/// Builds a ball over a floor. The floor's picture has odd sides and is minified far away.
fn textured() -> Scene {
    let mut scene = ball_over_floor();
    let texel = |k: u32| [k.wrapping_mul(2_654_435_761) >> 24, k.wrapping_mul(40_503) >> 8, k * 7, 255];
    let rgba8 = (0..45 * 27).flat_map(texel).map(|byte| byte as u8).collect();
    scene.images = vec![Image { width: 45, height: 27, rgba8 }];
    let sampler = Sampler { wrap_u: Wrap::Repeat, wrap_v: Wrap::MirroredRepeat, nearest: false };
    scene.materials[0].base_color_texture = Some(TextureRef { image: 0, sampler });
    scene.meshes[0].primitives[0].uvs = [[0.0, 0.0], [0.0, 4.0], [5.0, 4.0], [5.0, 0.0]].map(glam::Vec2::from).into();
    scene.meshes[1].primitives[0].uvs = vec![glam::Vec2::ZERO; scene.meshes[1].primitives[0].positions.len()];
    (scene.fill.sky, scene.fill.ground) = (DVec3::splat(0.3), DVec3::splat(0.1));
    scene
}

/// All contributions and the fill add up to the pixel of the reference's own picture, and the shares to 1.
///
/// Rules: PROBE-3
#[test]
fn the_parts_add_up_to_the_picture() {
    let scene = textured();
    let [bent, lamp, omni, sun] = from_above();
    let bent = bent.map_points(|i, point| point.position.x += if i == 3 { 0.3 } else { 0.0 });
    let lights = [
        bent.with(SHADOW_COLOR, DVec3::new(0.2, 0.0, 0.1)),
        lamp.with(LIGHT_LINK, Links::new(vec!["floor".into()], Vec::new())),
        omni.with(INTENSITY, 0.5),
        sun.with(INTENSITY, 2.0),
    ];
    let mut view: View = view(DVec3::new(2.5, 1.5, 1.0), DVec3::Y * 0.4, Aov::Beauty);
    view.camera.projection = scene::Projection::Perspective { yfov: 1.2, aspect_ratio: None, znear: 0.05, zfar: None };
    let picture = render(&scene, &view, &lights);
    let reference = for_points(&scene);
    let (lights, none) = (instances(&lights), BTreeSet::new());
    let (mut lit, mut partly, mut differ, mut background) = (0, 0, 0, 0);
    for (pixel, expected) in centres(&view).zip(&picture.pixels) {
        let Probe { seen, lights: found } = reference.probe(&view, pixel, &lights, &none).expect("a pixel");
        let Some(seen) = seen else {
            assert!(found.is_empty() && expected[3] == 0.0);
            background += 1;
            continue;
        };
        let sum = found.iter().map(|light| light.radiance).sum::<DVec3>() + seen.fill;
        let expected = DVec3::new(expected[0], expected[1], expected[2]);
        // The terms are equal, but textures are summed in another order: some hundred terms of at most 1.
        assert!(
            (sum - expected).abs().max_element() <= 1e-12 * (1.0 + expected.max_element()),
            "{pixel}: {sum} {expected}"
        );
        let shares: f64 = found.iter().map(|light| light.share).sum();
        let is_lit = found.iter().any(|light| light.radiance != DVec3::ZERO);
        assert!(if is_lit { (shares - 1.0).abs() < 1e-14 } else { shares == 0.0 }, "{pixel}: {shares}");
        lit += usize::from(is_lit);
        partly += usize::from(found.iter().any(|light| light.share > 0.01 && light.share < 0.99));
        // Deliberate fault that the check must detect: a muted light is missing.
        let muted = BTreeSet::from([LightId(3)]);
        let fewer = reference.probe(&view, pixel, &lights, &muted).expect("a pixel").lights;
        assert_eq!(fewer[3].state, LightState::Disabled(DisabledBy::Muted));
        let sum = fewer.iter().map(|light| light.radiance).sum::<DVec3>() + seen.fill;
        differ += usize::from((sum - expected).abs().max_element() > 1e-3);
    }
    println!("{lit} lit, {partly} by several, {differ} differ without the sun, {background} background");
    assert!(lit > 300 && partly > 100 && differ > 100 && background > 50);
}

/// Rules: PROBE-1
#[test]
fn pixels_outside_the_picture_are_refused_in_a_sentence() {
    let reference = for_points(&ball_over_floor());
    let mut view = view(DVec3::new(3.0, 1.5, 0.0), DVec3::ZERO, Aov::Beauty);
    let ask = |view: &View, x: f64, y: f64| reference.probe(view, DVec2::new(x, y), &[], &BTreeSet::new());
    assert!(ask(&view, 0.0, 0.0).is_ok() && ask(&view, 47.999, 31.999).is_ok());
    let outside = [(-0.5, 1.0), (48.0, 1.0), (1.0, 32.0), (f64::NAN, 1.0), (1.0, f64::INFINITY), (1e300, -1e300)];
    for (x, y) in outside {
        let error = ask(&view, x, y).expect_err("off the picture");
        assert!(error.to_string().ends_with("x goes from 0 to less than 48, y from 0 to less than 32"), "{error}");
    }
    view.width = 0;
    assert_eq!(ask(&view, 0.0, 0.0).map(|_| ()), Err(ReferenceError::EmptyView));
    (view.width, view.height) = (u32::MAX, u32::MAX);
    assert!(ask(&view, 2e9, 2e9).is_ok(), "as large as numbers go");
    view.camera.translation.x = f64::NAN;
    assert!(matches!(ask(&view, 0.0, 0.0), Err(ReferenceError::Camera(_))));
}

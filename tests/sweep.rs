//! Sets every parameter of every light once: the passes that run are those of its row, the picture is the reference's,
//! and undo restores the earlier picture to the bit.

use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3};
use light::parameters::{
    COLOR, COLOR_TEMPERATURE, CONE_ANGLE, CONE_SOFTNESS, CROSS_SECTION, CUT_OFF, CUT_ON, DECAY, DECAY_START,
    ENABLE_COLOR_TEMPERATURE, FAR_EDGE, HEIGHT, INTENSITY, NEAR_EDGE, PROFILE, PROFILE_POWER, RANGE, ROTATION,
    SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH, SHADOW_COLOR, TRANSLATION, UP, WIDTH,
};
use light::{
    CrossSection, Decay, Light, Links, Parameter, ParameterKind, ParameterOwner, ParameterTouches, PeriodicCurve,
    ProfileCurve, Setting, Value,
};
use reference::{LinkedReferenceLight, Reference, ReferenceLight, ShadedPoint};
use render::PassCounts;
use scene::{Aov, Fill, PosedScene, Scene, View, ViewSlot};

use crate::pictures::{PictureError, alone, around, renderer};

const SIZE: [u32; 2] = [120, 68];
/// Maximum relative root mean square error away from edges: normals are packed to 2^-15, which at grazing light, at a
/// cosine of 0.03, is a thousandth.
const LARGEST_RMSE: f64 = 1e-3;

/// Minimum error, against the picture with the parameter, of the picture without it: some times the error of the
/// picture with it.
const VISIBLE_CHANGE: f64 = 5e-4;

/// A light with all optional parameters, so that each one shows in `view`.
fn with_all(light: Light, reference: &Reference, view: &View) -> Light {
    // Distances along the light of the surfaces that it lights.
    let source = ReferenceLight::new(&light::CheckedLight::new(light.clone()).expect("valid"));
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
    let distance = |at| Some(reference.sample(&source, &reference.surface(view, at)?)?.coords.s);
    let mut distances: Vec<f64> = pixels.filter_map(distance).collect();
    distances.sort_by(f64::total_cmp);
    let [near, far] = [distances.len() / 20, distances.len() * 19 / 20].map(|index| distances[index]);
    let along = |share: f64| near + share * (far - near);
    let span = far - near;
    light
        .with(COLOR, DVec3::new(1.0, 0.9, 0.7))
        .with(ENABLE_COLOR_TEMPERATURE, true)
        .with(COLOR_TEMPERATURE, 4300.0)
        .with(DECAY, Decay::Linear)
        .with(DECAY_START, along(0.4))
        .with(CUT_ON, Some(along(0.5)))
        .with(NEAR_EDGE, 0.6 * span)
        .with(CUT_OFF, Some(along(0.6)))
        .with(FAR_EDGE, 0.5 * span)
        .with(RANGE, Some(along(0.8)))
        .with(CONE_SOFTNESS, 0.8)
        .with(PROFILE, ProfileCurve::Power)
        .with(PROFILE_POWER, 0.8)
        .with(CROSS_SECTION, CrossSection::Superellipse)
        .with(SECTION_WIDTH, 0.95)
        .with(SECTION_HEIGHT, 0.7)
        .with(SECTION_ROUNDNESS, 0.6)
        .with(SHADOW_COLOR, DVec3::new(0.05, 0.1, 0.3))
}

/// The demo, and a light of each shape over it, without the scene's fill, which would make differences look smaller.
fn demo() -> (Arc<PosedScene>, View, Vec<Light>) {
    let loaded = assets::demo("vases").expect("it is one of the demos");
    let fill = Fill { sky: DVec3::ZERO, ground: DVec3::ZERO };
    let view = View::beauty(loaded.contents.cameras[0].clone(), SIZE);
    let source = DVec3::new(-1.4, 2.6, 1.4);
    // The light ends among the vases, so that parameters of its end show.
    let points = [[0.0, 0.0, 0.0], [0.1, 0.5, 0.0], [1.0, -0.2, -0.9], [1.5, -1.6, -1.4], [1.8, -2.7, -1.7]];
    let bent = Light::bendy(points.map(DVec3::from_array).into(), vec![0.1, 0.2, 0.5, 1.1, 1.3]);
    let bent = bent.with(TRANSLATION, source).with(UP, DVec3::new(0.3, 1.0, 0.2)).with(INTENSITY, 9.0);
    let aimed = DQuat::from_rotation_arc(DVec3::NEG_Z, (DVec3::new(0.0, 0.5, 0.0) - source).normalize());
    let spot = Light::spot().with(TRANSLATION, source).with(ROTATION, aimed);
    let spot = spot.with(INTENSITY, 12.0).with(CONE_ANGLE, 30.0);
    let omni = Light::omni().with(TRANSLATION, DVec3::new(-0.4, 1.7, 0.9)).with(INTENSITY, 4.0);
    let sun = Light::directional().with(TRANSLATION, source).with(ROTATION, aimed).with(INTENSITY, 3.0);
    let sun = sun.with(WIDTH, Some(1.8)).with(HEIGHT, Some(1.4));
    (scene::pose(Scene { fill, ..loaded.scene }, 0.0), view, vec![bent, spot, omni, sun])
}

/// Other values for a parameter: one, or every other one of a choice. Links exclude `node`.
fn others(parameter: &Parameter, now: &Value, node: &str) -> Vec<Value> {
    let any_of = |numbers: &[f64]| {
        let allowed = numbers.iter().map(|&number| Value::Number(number));
        allowed.filter(|value| value != now && parameter.check(value).is_ok()).take(1).collect()
    };
    match (&parameter.kind, now) {
        (ParameterKind::Links, _) => Links::new(Vec::new(), vec![node.into()]).map(Value::Links).into_iter().collect(),
        (ParameterKind::Choice(choices), _) => {
            choices.iter().map(|choice| Value::Choice(choice.name)).filter(|value| value != now).collect()
        }
        (ParameterKind::PeriodicCurve { .. }, _) => {
            // A cutout with a corner, at three quarters of the circle.
            let knots = vec![[20.0, 0.9], [100.0, 0.6], [130.0, 0.95], [290.0, 0.75]];
            PeriodicCurve::new(knots).map(Value::PeriodicCurve).into_iter().collect()
        }
        (_, Value::Choice(_) | Value::Links(_) | Value::PeriodicCurve(_)) => Vec::new(),
        (_, Value::Flag(flag)) => vec![Value::Flag(!flag)],
        // A light that is slightly wider, longer or brighter is still valid.
        (_, Value::Number(number)) => any_of(&[number * 1.2, number * 0.8, number + 0.5]),
        (_, Value::Absent) => any_of(&[2.0]),
        (_, Value::Vector(vector)) => vec![Value::Vector(*vector + DVec3::new(0.1, -0.05, 0.08))],
        (_, Value::Rotation(rotation)) => vec![Value::Rotation(*rotation * DQuat::from_rotation_y(0.1))],
        (_, Value::Text(text)) => vec![Value::Text(format!("{text}e"))],
    }
}

fn since(before: PassCounts, after: PassCounts) -> [u64; 3] {
    [after.gbuffer - before.gbuffer, after.shadow - before.shadow, after.lighting - before.lighting]
}

/// Properties at a pixel's center that must not change nearby if the pixel is compared.
#[derive(Clone, Copy)]
struct PixelCenter {
    node: usize,
    normal: DVec3,
    depth: f64,
    lit: Option<bool>,
    /// True if the point is inside the outline, at which the profile can be a step.
    shines: bool,
}

/// Radiance by the reference of the pixels that are compared.
fn expected(reference: &Reference, view: &View, light: &Light) -> Vec<Option<DVec3>> {
    let checked = light::CheckedLight::new(light.clone()).expect("valid");
    let source = ReferenceLight::new(&checked);
    let linked = [LinkedReferenceLight::new(&reference.bvh.posed, &checked)];
    let [width, height] = SIZE.map(|side| side as usize);
    let at = |index: usize| DVec2::new((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
    let surfaces: Vec<Option<ShadedPoint>> =
        (0..width * height).map(|index| reference.surface(view, at(index))).collect();
    let seen: Vec<Option<PixelCenter>> = surfaces
        .iter()
        .map(|surface| {
            let surface = surface.as_ref()?;
            let sample = reference.sample(&source, surface);
            let (lit, shines) = (sample.map(|s| s.is_visible), sample.is_some_and(|s| s.irradiance != DVec3::ZERO));
            Some(PixelCenter { node: surface.node, normal: surface.normal, depth: surface.depth, lit, shines })
        })
        .collect();
    let alike = |a: PixelCenter, b: PixelCenter| {
        a.normal.dot(b.normal) > 0.9
            && (a.depth / b.depth - 1.0).abs() < 0.05
            && (a.node, a.lit, a.shines) == (b.node, b.lit, b.shines)
    };
    let off_boundary = |index: usize| {
        let is_alike = |here, other: usize| seen[other].is_some_and(|there| alike(here, there));
        seen[index].is_some_and(|here| around(index, SIZE, 2).all(|other| is_alike(here, other)))
    };
    let radiance = |index: usize| {
        let surface = surfaces[index].as_ref().filter(|_| off_boundary(index))?;
        Some(reference.radiance(&linked, 0.0, surface))
    };
    (0..width * height).map(radiance).collect()
}

#[test]
fn every_parameter_of_every_shape_does_what_its_row_says() {
    let (posed, view, lights) = demo();
    let view = View { aov: Aov::Beauty, slot: ViewSlot(1), ..view };
    let reference = Reference::new(Arc::clone(&posed));
    let mut renderer = renderer();
    renderer.set_scene(&posed).expect("the scene fits");
    let mut draw = |light: &Light| {
        let before = renderer.counts();
        let picture = renderer.render(&view, &alone(light)).expect("it can be drawn");
        (picture, since(before, renderer.counts()))
    };
    let mut faults = Vec::new();
    let (paths, _) = posed.node_tree().drawn_paths(100, 1000);
    let vase = paths.into_iter().find(|path| path.contains("vase")).expect("the demo has vases");
    for light in lights {
        let base = &with_all(light, &reference, &view);
        let shape = base.owner();
        let (base_picture, [_, shadow, lighting]) = draw(base);
        assert_eq!((shadow, lighting), (1, 1), "{shape:?}");
        let base_expected = expected(&reference, &view, base);
        for (parameter, now) in base.values() {
            let touches = parameter.for_owner(shape).expect("it has it").touches;
            for value in others(parameter, now, &vase) {
                let what = format!("{shape:?} {} {value:?}", parameter.name);
                let mut set = base.clone();
                set.set(Setting { parameter, value: value.clone() });
                let (picture, passes) = draw(&set);
                let allowed = match touches {
                    ParameterTouches::Nothing => [0, 0, 0],
                    ParameterTouches::Weight | ParameterTouches::Radiance => [0, 0, 1],
                    ParameterTouches::ShadowMap | ParameterTouches::Scene => [0, 1, 1],
                };
                let PictureError { relative_rmse: off, compared } =
                    PictureError::new(&picture, expected(&reference, &view, &set));
                // The planted fault: the parameter is not set. An omni light has no direction, so its rotation shows
                // only in a projected image.
                let shows = touches > ParameterTouches::Nothing
                    && (shape, parameter.name) != (ParameterOwner::Omni, "rotation");
                let unset = PictureError::new(&picture, base_expected.iter().copied()).relative_rmse;
                let (undone, [gbuffer, ..]) = draw(base);
                let wrong = [
                    (passes != allowed, format!("{passes:?} passes instead of {allowed:?}")),
                    (off > LARGEST_RMSE, format!("{off:e} off")),
                    (compared < 3000, format!("only {compared} pixels compared")),
                    ((unset > VISIBLE_CHANGE) != shows, format!("{unset:e} off unset")),
                    (undone.pixels != base_picture.pixels || gbuffer > 0, "another picture undone".into()),
                ];
                let wrong = wrong.into_iter().filter(|(is_so, _)| *is_so);
                faults.extend(wrong.map(|(_, fault)| format!("{what}: {fault}")));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

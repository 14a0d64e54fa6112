//! Drags without sense: any pixels, points, pins and alternatives, by lights of any size.

use drag::{
    Alternative, Drag, DragChoice, DragPin, DragResult, DragStatus, Feature, MAX_DRAG_STEPS, NumberedPin, PinKind,
    PinTarget, RadiusMode, Viewport, WorkBudget, drag_alternatives, drag_budgeted,
};
use glam::{DQuat, DVec2, DVec3};
use light::parameters::{CONE_ANGLE, ROTATION, TRANSLATION};
use light::{CheckedLight, Light};

use crate::support::{Random, TestScene, demo};

/// Number of drags; 20,000 take about a minute, optimized.
const DRAGS: u64 = 1_500;

/// Most steps that a drag spends between two checks of its budget.
const AT_ONCE: u64 = 100_000;

/// Each drag ends within its budget with a light that can be evaluated, the same again, and one that is refused leaves the
/// light as it is.
///
/// Rules: DRAG-7
#[test]
fn drags_without_sense_end() {
    let scene = demo();
    let (mut landed, mut limited, mut refused) = (0, 0, 0);
    for seed in 0..DRAGS {
        let mut random = Random(seed);
        let Some((light, drag, pins)) = nonsense(&scene, &mut random) else { continue };
        let work = WorkBudget::new(&|_| true);
        let solve = |work: &WorkBudget| drag_budgeted(&scene.bvh, &light, &drag, &pins, work);
        let result = solve(&work);
        assert!(work.spent_steps() <= MAX_DRAG_STEPS + 2 * AT_ONCE, "{seed}: {}", work.spent_steps());
        check(seed, &light, &result);
        match result.outcome.status {
            DragStatus::Landed => landed += 1,
            DragStatus::Limited(_) => limited += 1,
            DragStatus::Refused(_) => refused += 1,
        }
        if seed % 50 == 0 {
            let again = solve(&WorkBudget::new(&|_| true));
            // Not `==`, by which a NaN is not itself.
            assert_eq!(format!("{result:?}"), format!("{again:?}"), "{seed}");
            let work = WorkBudget::new(&|_| true);
            let all = drag_alternatives(&scene.bvh, &light, &drag, &pins, &work);
            for result in &all {
                check(seed, &light, result);
            }
            assert!(work.spent_steps() <= MAX_DRAG_STEPS + 2 * AT_ONCE, "{seed}: {}", work.spent_steps());
        }
    }
    println!("{landed} landed, {limited} limited, {refused} refused");
    assert!(landed > DRAGS / 100 && refused > DRAGS / 4, "{landed} {limited} {refused}");
}

fn check(seed: u64, light: &CheckedLight, result: &DragResult) {
    let outcome = &result.outcome;
    if let DragStatus::Refused(_) = outcome.status {
        assert_eq!(&result.light, light.light(), "{seed}: {outcome:?}");
        assert!(result.copy.is_none(), "{seed}");
    } else {
        assert!(CheckedLight::new(result.light.clone()).is_ok(), "{seed}: {:?}", result.light);
        assert!(outcome.residual_px.is_finite() && outcome.residual_px >= 0.0, "{seed}: {outcome:?}");
    }
}

fn nonsense(scene: &TestScene, random: &mut Random) -> Option<(CheckedLight, Drag, Vec<NumberedPin>)> {
    let light = any_light(scene, random)?;
    let count = light.light().points().len();
    let choices = [None, Some(DragChoice::Best)].into_iter();
    let choices: Vec<_> = choices.chain(Alternative::ALL.map(|which| Some(DragChoice::Only(which)))).collect();
    let pick = |random: &mut Random, count: usize| random.between(0.0, count as f64) as usize;
    let features = [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse];
    let radii = [RadiusMode::Keep, RadiusMode::Follow, RadiusMode::Solve];
    let points = (pick(random, 3) == 0).then(|| (0..pick(random, 6)).map(|_| pick(random, count + 2)).collect());
    // Mostly in the light: most drags elsewhere end at once.
    let from = (0..12).map(|_| pixel(random)).find(|pixel| scene.tube_point(&light, *pixel).is_some());
    let from = from.unwrap_or_else(|| pixel(random));
    let to = if pick(random, 2) == 0 { pixel(random) } else { from + DVec2::splat(random.between(-30.0, 30.0)) };
    let sizes = [scene.view.size, [1, 1], [7, 4000]];
    let size = if pick(random, 8) == 0 { sizes[pick(random, 3)] } else { scene.view.size };
    let drag = Drag {
        feature: features[pick(random, 4)],
        choice: choices[pick(random, choices.len())],
        points,
        radii: radii[pick(random, 3)],
        view: Viewport { size, ..scene.view.clone() },
        from,
        to,
        pins: None,
        source_outside: pick(random, 2) == 0,
    };
    let pins = (0..pick(random, 9)).map(|_| any_pin(scene, random));
    Some((light, drag, NumberedPin::by_index(pins)))
}

/// Returns a pixel in the picture, or far beside it.
fn pixel(random: &mut Random) -> DVec2 {
    let pixel = random.pixel();
    if random.between(0.0, 1.0) < 0.05 { pixel * 1e6 - 5e5 } else { pixel }
}

/// Makes a light of any shape and size that aims near a visible surface; its tube may be sharply bent or nearly fold.
fn any_light(scene: &TestScene, random: &mut Random) -> Option<CheckedLight> {
    let aim = scene.seen(random.pixel())?.position + scene.bvh.posed.origin_in_world;
    let mut ball = |size: f64| {
        let mut between = || random.between(-size, size);
        DVec3::new(between(), between(), between())
    };
    let source = aim + ball(4.0).abs() + DVec3::Y;
    let aside: Vec<DVec3> = (0..8).map(|_| ball(1.0)).collect();
    let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, (aim - source).normalize());
    let place = |light: Light| light.with(TRANSLATION, source).with(ROTATION, turn);
    let scale = libm::exp10(random.between(-3.0, 3.0));
    let length = source.distance(aim) * if random.between(0.0, 1.0) < 0.2 { scale } else { 1.2 };
    let light = match random.between(0.0, 8.0) as usize {
        0 => Light::spot().with(CONE_ANGLE, random.between(1.0, 60.0)),
        1 => Light::omni(),
        2 => Light::directional(),
        _ => {
            let segments = 1 + random.between(0.0, 6.0) as usize;
            let bend = length * libm::exp10(random.between(-3.0, 0.0));
            let radius = length * libm::exp10(random.between(-4.0, -0.5));
            let along = light::greville_abscissae(segments).into_iter().map(|g| g / segments as f64);
            let points = along.zip(&aside).map(|(g, aside)| {
                let aside = if g > 0.0 { *aside * bend } else { DVec3::ZERO };
                (DVec3::NEG_Z * (g * length) + aside, radius * (0.1 + 0.9 * g))
            });
            let (points, radii) = points.unzip();
            Light::bendy(points, radii)
        }
    };
    CheckedLight::new(place(light)).ok()
}

/// Makes a pin on a surface, in the air, far away, on a node or on none.
fn any_pin(scene: &TestScene, random: &mut Random) -> DragPin {
    let kinds =
        [PinKind::Direction, PinKind::Look, PinKind::Lit, PinKind::Shadowed, PinKind::Shadow, PinKind::Coordinates];
    let origin = scene.bvh.posed.origin_in_world;
    let seen = scene.seen(random.pixel()).map_or(DVec3::ZERO, |seen| seen.position + origin);
    let at = match random.between(0.0, 6.0) as usize {
        0 => PinTarget::Point(seen + DVec3::splat(random.between(-1.0, 1.0))),
        1 => PinTarget::Point(seen * 1e9),
        2 => PinTarget::Node("blue vase".into()),
        3 => PinTarget::Node("no such node".into()),
        _ => PinTarget::Point(seen),
    };
    let caster = (random.between(0.0, 4.0) < 1.0).then(|| "orange vase".into());
    let is_hard = random.between(0.0, 2.0) < 1.0;
    DragPin { kind: kinds[random.between(0.0, 6.0) as usize], at, caster, is_hard }
}

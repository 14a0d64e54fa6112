//! Pins hold. Measurements that share nothing with the solver check them.

use drag::{DragLimit, DragPin, DragRefusal, DragStatus, Feature, NumberedPin, PinKind, RadiusMode, drag};
use glam::{DVec2, DVec3};
use light::CheckedLight;
use reference::{Reference, ReferenceLight, ShadedPoint};
use scene::View;

use crate::support::{self, Random, TestScene, Trial, trials};

/// Pin, and the pixel that shows its point.
struct VisiblePin {
    pin: DragPin,
    pixel: DVec2,
}

/// Measures the error of a pin: in degrees for a direction, in pixels for a shadow, else 0, or infinite if it does not
/// hold.
fn pin_error(reference: &Reference, trial: &Trial, pinned: &VisiblePin, now: &CheckedLight) -> f64 {
    let origin = reference.bvh.posed.origin_in_world;
    let view = View::beauty(trial.drag.view.camera.clone(), trial.drag.view.size);
    let surface = |pixel| reference.surface(&view, pixel);
    let Some(here) = surface(pinned.pixel) else { return f64::INFINITY };
    let located = |light: &CheckedLight, at: DVec3| light.tube().and_then(|tube| tube.locate(at).point);
    let (Some(was), Some(is)) = (located(&trial.light, pinned.pin.at), located(now, pinned.pin.at)) else {
        return f64::INFINITY;
    };
    let is_lit =
        |surface: &ShadedPoint| reference.sample(&ReferenceLight::new(now), surface).is_some_and(|s| s.is_visible);
    let zero_if = |holds: bool| if holds { 0.0 } else { f64::INFINITY };
    match pinned.pin.kind {
        PinKind::Direction => was.direction.angle_between(is.direction).to_degrees(),
        PinKind::Lit => zero_if(is_lit(&here)),
        PinKind::Shadowed => zero_if(!is_lit(&here)),
        PinKind::Shadow => {
            // Finds the pivot anew: the first surface on the light path at the start.
            let tube = trial.light.tube().expect("a BendyLight");
            let path = reference.bvh.bent_path(tube, was.v, was.w);
            let away = 1e-5 * reference.bvh.posed.half_extent.length();
            let point = pinned.pin.at - origin;
            let hit = reference.bvh.first_bent_hit(&path, was.t, |hit| hit.position.distance(point) > away);
            let Some(pivot) = hit.and_then(|hit| located(now, hit.position + origin)) else {
                return f64::INFINITY;
            };
            let beside = surface(pinned.pixel + DVec2::X);
            let per_pixel = beside.map_or(0.01 * here.depth, |beside| beside.position.distance(here.position));
            let px = libm::hypot(pivot.v - is.v, pivot.w - is.w) * is.radius / per_pixel.max(1e-4 * here.depth);
            if pivot.t < is.t { px } else { f64::INFINITY }
        }
    }
}

/// Makes up to three pins that hold at the start, at visible points in the light.
fn random_pins(scene: &TestScene, reference: &Reference, trial: &Trial, random: &mut Random) -> Vec<VisiblePin> {
    let view = View::beauty(trial.drag.view.camera.clone(), trial.drag.view.size);
    let mut pins = Vec::new();
    for _ in 0..400 {
        let pixel = random.pixel();
        let Some((seen, _)) = scene.tube_point(&trial.light, pixel) else { continue };
        let Some(surface) = reference.surface(&view, pixel) else { continue };
        let Some(sample) = reference.sample(&ReferenceLight::new(&trial.light), &surface) else { continue };
        // Skips light that grazes a facet or passes by rounding.
        if seen.normal.dot(sample.coords.direction) < 0.1 || seen.geometric_normal.dot(sample.coords.direction) < 0.1 {
            continue;
        }
        let kind = match (sample.is_visible, random.between(0.0, 1.0) < 0.5) {
            (true, true) => PinKind::Lit,
            (_, true) => PinKind::Shadowed,
            (true, false) => PinKind::Direction,
            (false, false) => PinKind::Shadow,
        };
        let at = seen.position + scene.bvh.posed.origin_in_world;
        let is_hard = random.between(0.0, 1.0) < 0.6;
        pins.push(VisiblePin { pin: DragPin { kind, at, caster: None, is_hard }, pixel });
        if pins.len() == 3 {
            break;
        }
    }
    pins
}

/// In 200 sets of three pins, with lights that move as a whole and lights that bend, the hard pins hold, and a drag
/// that converges only without pins names one. The study of drags measures how many more a slow solver solves.
///
/// Rules: DRAG-5
#[test]
fn hard_pins_hold_wherever_the_drag_ends() {
    const SETS: usize = 200;
    let (mut landed, mut by_pin, mut alike, mut was_off) = (0, 0, 0, 0);
    let scenes = support::scenes();
    for scene in &scenes {
        let reference = scene.reference();
        let mut random = Random(77);
        for feature in [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse] {
            for mut trial in trials(scene, feature, SETS.div_ceil(4 * scenes.len())) {
                let pinned = random_pins(scene, &reference, &trial, &mut random);
                trial.pins = pinned.iter().map(|placed| placed.pin.clone()).collect();
                let result = scene.run(&trial);
                let what = || format!("{} {feature:?} {:?}: {result:?}", scene.name, trial.drag);
                let free = drag(&scene.bvh, &trial.light, &trial.drag, &[]);
                match result.outcome.status {
                    DragStatus::Landed => landed += 1,
                    DragStatus::Limited(DragLimit::Pin(number)) => {
                        assert!(trial.pins[number as usize].is_hard, "{}", what());
                        by_pin += 1;
                    }
                    // Another limit acts without pins too.
                    _ => {
                        assert_ne!(free.outcome.status, DragStatus::Landed, "{}", what());
                        alike += 1;
                    }
                }
                let now = CheckedLight::new(result.light.clone()).expect("valid");
                let free = CheckedLight::new(free.light).expect("valid");
                let most = |placed: &VisiblePin| if placed.pin.kind == PinKind::Direction { 0.1 } else { 0.5 };
                let hard = || pinned.iter().filter(|placed| placed.pin.is_hard);
                for placed in hard() {
                    let off = pin_error(&reference, &trial, placed, &now);
                    assert!(off < most(placed), "{off} {:?} {}", placed.pin, what());
                }
                // Deliberate fault that the check must detect: without pins something is off.
                was_off +=
                    usize::from(hard().any(|placed| pin_error(&reference, &trial, placed, &free) > most(placed)));
            }
        }
    }
    println!("{landed} landed, {by_pin} limited by pins, {alike} as without; {was_off} would not hold");
    assert!(landed + by_pin + alike >= SETS);
    assert!(landed * 2 >= SETS && was_off * 3 > SETS);
}

/// An infeasible drag is limited by the pin that prevents it, and a hard pin that does not hold at the start is named.
///
/// Rules: DRAG-5
#[test]
fn infeasible_drags_name_the_pin() {
    let scene = support::demo();
    let mut named = 0;
    for mut trial in trials(&scene, Feature::Diffuse, 24) {
        let to = scene.seen(trial.drag.to).expect("a surface");
        let origin = scene.bvh.posed.origin_in_world;
        let far = trial.light.tube().and_then(|tube| tube.locate(to.position + origin).point).expect("inside");
        if far.direction.angle_between(to.normal) < 0.02 || scene.run(&trial).outcome.status != DragStatus::Landed {
            continue;
        }
        let other = scene.outside(&trial.light);
        let outside = scene.seen(other).expect("a surface").position + origin;
        let pin = |kind, at| DragPin { kind, at, caster: None, is_hard: true };
        // The drag must change the direction at M', and the pin must keep it.
        trial.pins = vec![pin(PinKind::Direction, to.position + origin)];
        let result = scene.run(&trial);
        assert_eq!(result.outcome.status, DragStatus::Limited(DragLimit::Pin(0)), "{result:?}");
        // A soft pin yields.
        trial.pins[0].is_hard = false;
        let soft = scene.run(&trial);
        assert_ne!(soft.outcome.status, DragStatus::Limited(DragLimit::Pin(0)), "{soft:?}");
        trial.pins.push(pin(PinKind::Lit, outside));
        assert_eq!(scene.run(&trial).outcome.status, DragStatus::Refused(DragRefusal::PinDoesNotHold(1)));
        trial.pins[1].is_hard = false;
        assert_eq!(scene.run(&trial).light, soft.light);
        named += 1;
    }
    assert!(named > 5, "{named}");
}

/// A source that must stay outside goes through no surface, and comes as near as that allows.
///
/// Rules: DRAG-6
#[test]
fn the_source_stays_outside() {
    let scene = support::demo();
    let (mut kept, mut through) = (0, 0);
    for mut trial in trials(&scene, Feature::Highlight, 60) {
        trial.drag.points = None;
        let source = |result: &drag::DragResult| result.light.transform().translation;
        let origin = scene.bvh.posed.origin_in_world;
        let from = trial.light.light().transform().translation;
        let goes_through = |to: DVec3| scene.bvh.first_hit(from - origin, to - from, [0.0, 1.0], |_| true).is_some();
        let free = scene.run(&trial);
        if !goes_through(source(&free)) {
            continue;
        }
        through += 1;
        trial.drag.source_outside = true;
        let result = scene.run(&trial);
        assert!(!goes_through(source(&result)), "{result:?}");
        let says = matches!(result.outcome.status, DragStatus::Landed | DragStatus::Limited(DragLimit::SourceInside));
        kept += usize::from(says);
        println!("{:?} {}", result.outcome.status, result.outcome.residual_px);
    }
    println!("{through} would go through something, {kept} say why not");
    assert!(through > 0 && kept * 2 > through);
}

/// The shadow of the blue vase moves, and the vase keeps its look where directions are pinned: the same irradiance from
/// the same direction, within a step of 255.
#[test]
fn a_pinned_caster_keeps_its_look_while_its_shadow_moves() {
    let scene = support::demo();
    let reference = scene.reference();
    let mut trial = scene.trial_of_the_demo(None);
    trial.drag.points = Some(vec![1, 2, 3, 4]);
    trial.drag.radii = RadiusMode::Solve;
    trial.drag.to = DVec2::new(410.5, 300.5);
    let view = View::beauty(trial.drag.view.camera.clone(), trial.drag.view.size);
    let pixels = [(140.5, 150.5), (165.5, 100.5), (200.5, 180.5)].map(DVec2::from);
    let surfaces = pixels.map(|pixel| reference.surface(&view, pixel).expect("the vase"));
    let origin = scene.bvh.posed.origin_in_world;
    let at = surfaces.each_ref().map(|surface| surface.position + origin);
    let pins = at.map(|at| DragPin { kind: PinKind::Direction, at, caster: None, is_hard: true }).to_vec();
    let differs = |light: &light::Light| {
        let lit = |light: &CheckedLight, surface: &ShadedPoint| {
            let sample = reference.sample(&ReferenceLight::new(light), surface).expect("inside the light");
            sample.irradiance * surface.normal.dot(sample.coords.direction).max(0.0)
        };
        let now = CheckedLight::new(light.clone()).expect("valid");
        let off = surfaces.iter().map(|surface| (lit(&now, surface) - lit(&trial.light, surface)).abs().max_element());
        off.fold(0.0, f64::max)
    };
    let free = scene.run(&trial);
    let pinned = drag(&scene.bvh, &trial.light, &trial.drag, &NumberedPin::by_index(pins));
    assert_eq!((free.outcome.status, pinned.outcome.status), (DragStatus::Landed, DragStatus::Landed));
    let (without, with) = (differs(&free.light), differs(&pinned.light));
    // The smallest linear difference of a step of sRGB, in the dark, is 1 / 12.92 / 255.
    assert!(with < 1.0 / 12.92 / 255.0, "{with}");
    assert!(without > 1.0 / 255.0, "{without}: nothing had to be held");
}

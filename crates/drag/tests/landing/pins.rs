//! Pins hold. Measurements that share nothing with the solver check them.

use drag::{
    Drag, DragLimit, DragPin, DragRefusal, DragResult, DragStatus, Feature, NumberedPin, PinKind, PinTarget,
    RadiusMode, Viewport, drag,
};
use glam::{DQuat, DVec2, DVec3};
use light::CheckedLight;
use reference::{Reference, ReferenceLight, ShadedPoint};
use scene::{Camera, View, ViewRay};

use crate::support::{self, Random, TestScene, Trial, trials};

/// Pin, and the pixel that shows its point.
pub struct VisiblePin {
    pub pin: DragPin,
    pub at: DVec3,
    pub pixel: DVec2,
}

/// Measures the error of a pin: in degrees for a direction, in pixels for a shadow, else 0, or infinite if it does not
/// hold.
pub fn pin_error(reference: &Reference, trial: &Trial, pinned: &VisiblePin, now: &CheckedLight) -> f64 {
    let origin = reference.bvh.posed.origin_in_world;
    let view = View::beauty(trial.drag.view.camera.clone(), trial.drag.view.size);
    let surface = |pixel| reference.surface(&view, pixel);
    let Some(here) = surface(pinned.pixel) else { return f64::INFINITY };
    let located = |light: &CheckedLight, at: DVec3| light.tube().and_then(|tube| tube.locate(at).point);
    let (Some(was), Some(is)) = (located(&trial.light, pinned.at), located(now, pinned.at)) else {
        return f64::INFINITY;
    };
    let is_lit =
        |surface: &ShadedPoint| reference.sample(&ReferenceLight::new(now), surface).is_some_and(|s| s.is_visible);
    let zero_if = |holds: bool| if holds { 0.0 } else { f64::INFINITY };
    match pinned.pin.kind {
        PinKind::Direction => was.direction.angle_between(is.direction).to_degrees(),
        PinKind::Look => unreachable!("no such pin is made"),
        PinKind::Coordinates => libm::hypot(was.v - is.v, was.w - is.w),
        PinKind::Lit => zero_if(is_lit(&here)),
        PinKind::Shadowed => zero_if(!is_lit(&here)),
        PinKind::Shadow => {
            // Finds the pivot anew: the first surface on the light path at the start.
            let tube = trial.light.tube().expect("a BendyLight");
            let path = reference.bvh.bent_path(tube, was.v, was.w);
            let away = 1e-5 * reference.bvh.posed.half_extent.length();
            let point = pinned.at - origin;
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
pub fn random_pins(scene: &TestScene, reference: &Reference, trial: &Trial, random: &mut Random) -> Vec<VisiblePin> {
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
        let pin = DragPin { kind, at: PinTarget::Point(at), caster: None, is_hard };
        pins.push(VisiblePin { pin, at, pixel });
        if pins.len() == 3 {
            break;
        }
    }
    pins
}

/// True if the limit ends the drag on its way, or before a third of it.
fn is_limited_by(result: &DragResult, limit: DragLimit) -> bool {
    let status = result.outcome.status;
    status == DragStatus::Limited(limit) || status == DragStatus::Refused(DragRefusal::Limited(limit))
}

/// In 200 sets of three pins, with lights that move as a whole and lights that bend, the hard pins hold, and a drag
/// that lands only without pins names one. Half of the drags go to any pixel of the picture.
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
                    DragStatus::Limited(DragLimit::Pin(number))
                    | DragStatus::Refused(DragRefusal::Limited(DragLimit::Pin(number))) => {
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
    assert!(landed * 5 >= 2 * SETS && was_off * 3 > SETS);
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
        let pin = |kind, at| DragPin { kind, at: PinTarget::Point(at), caster: None, is_hard: true };
        // The drag must change the direction at M', and the pin must keep it.
        trial.pins = vec![pin(PinKind::Direction, to.position + origin)];
        let result = scene.run(&trial);
        assert!(is_limited_by(&result, DragLimit::Pin(0)), "{result:?}");
        // A soft pin yields.
        trial.pins[0].is_hard = false;
        let soft = scene.run(&trial);
        assert!(!is_limited_by(&soft, DragLimit::Pin(0)), "{soft:?}");
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
        let source = |result: &DragResult| result.light.transform().translation;
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
        let says = result.outcome.status == DragStatus::Landed || is_limited_by(&result, DragLimit::SourceInside);
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
    let pins = at
        .map(|at| DragPin { kind: PinKind::Direction, at: PinTarget::Point(at), caster: None, is_hard: true })
        .to_vec();
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

/// Picture of a node in a light: the brightness of its pixels as displays show it, 0 to 255.
pub struct NodePicture<'a> {
    reference: &'a Reference,
    pub surfaces: Vec<ShadedPoint>,
    brightest: f64,
}

impl<'a> NodePicture<'a> {
    pub fn new(scene: &TestScene, reference: &'a Reference, trial: &Trial, node: &str) -> Self {
        let view = View::beauty(trial.drag.view.camera.clone(), trial.drag.view.size);
        let index = scene.bvh.posed.scene.nodes.iter().position(|other| other.name == node).expect("the scene has it");
        let pixels = (0..64 * 36).map(|k| DVec2::new(f64::from(k % 64) + 0.5, f64::from(k / 64) + 0.5) * 10.0);
        let is_of_node = |pixel: &DVec2| {
            let ray = ViewRay::new(&view.camera, trial.drag.view.size, *pixel, scene.bvh.posed.origin_in_world);
            scene.bvh.visible_point(&ray).is_some_and(|seen| seen.node == index)
        };
        let surfaces = pixels.filter(is_of_node).filter_map(|pixel| reference.surface(&view, pixel)).collect();
        let mut picture = Self { reference, surfaces, brightest: 1.0 };
        picture.brightest = picture.lit(trial.light.light()).into_iter().fold(0.0, f64::max);
        picture
    }

    fn lit(&self, light: &light::Light) -> Vec<f64> {
        let light = ReferenceLight::new(&CheckedLight::new(light.clone()).expect("valid"));
        let lit = |surface: &ShadedPoint| {
            let sample = self.reference.sample(&light, surface).filter(|sample| sample.is_visible)?;
            Some(sample.irradiance.max_element() * surface.normal.dot(sample.coords.direction).max(0.0))
        };
        self.surfaces.iter().map(|surface| lit(surface).unwrap_or(0.0)).collect()
    }

    /// Measures how many of 255 nine in ten pixels differ between two lights at most.
    pub fn difference(&self, one: &light::Light, other: &light::Light) -> f64 {
        let in_srgb = |brightness: f64| {
            let linear = brightness / self.brightest;
            255.0 * if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
        };
        let pairs = self.lit(one).into_iter().zip(self.lit(other));
        let mut off: Vec<f64> = pairs.map(|(one, other)| (in_srgb(one) - in_srgb(other)).abs()).collect();
        off.sort_by(f64::total_cmp);
        off[off.len() * 9 / 10]
    }
}

/// The blue vase is pinned by its name, and keeps its look within 8 of 255 while its shadow moves.
///
/// Rules: DRAG-5
#[test]
fn a_pinned_node_keeps_its_look_while_its_shadow_moves() {
    let scene = support::demo();
    let reference = scene.reference();
    let trial = scene.trial_of_the_demo(None);
    let vase = NodePicture::new(&scene, &reference, &trial, "blue vase");
    assert!(vase.surfaces.len() > 100, "{}", vase.surfaces.len());
    let pin = DragPin { kind: PinKind::Look, at: PinTarget::Node("blue vase".into()), caster: None, is_hard: true };
    let (mut landed, mut differs_free) = (0, 0);
    for to in [(410.5, 285.5), (440.5, 290.5), (420.5, 275.5), (430.5, 300.5)] {
        for points in [Some(vec![1, 2, 3, 4]), None] {
            let drag = Drag { to: DVec2::from(to), points, radii: RadiusMode::Follow, ..trial.drag.clone() };
            let run = |pins: &[NumberedPin]| crate::drag(&scene.bvh, &trial.light, &drag, pins);
            let (free, pinned) = (run(&[]), run(&NumberedPin::by_index([pin.clone()])));
            let off = [&free, &pinned].map(|result| vase.difference(trial.light.light(), &result.light));
            println!("{to:?} {:?}: {:?} off by {off:.1?}", drag.points, pinned.outcome.status);
            assert!(off[1] < 8.0, "{off:?} {:?}", pinned.outcome);
            landed += usize::from(pinned.outcome.status == DragStatus::Landed);
            differs_free += usize::from(off[0] > 8.0);
        }
    }
    assert!(landed >= 4, "{landed} of 8 landed");
    assert!(differs_free >= 6, "the planted fault: without the pin the vase looks otherwise, and {differs_free} do");
}

/// A hard pin of a point keeps the look within 2 of 255, or the place in the light.
///
/// Rules: DRAG-5
#[test]
fn a_pinned_point_keeps_its_look_and_its_place() {
    let scene = support::demo();
    let reference = scene.reference();
    let trial = scene.trial_of_the_demo(None);
    let drag = Drag { to: DVec2::new(410.5, 285.5), points: Some(vec![1, 2, 3, 4]), ..trial.drag.clone() };
    let pixel = DVec2::new(165.5, 150.5);
    let view = View::beauty(drag.view.camera.clone(), drag.view.size);
    let surface = reference.surface(&view, pixel).expect("the vase");
    let at = surface.position + scene.bvh.posed.origin_in_world;
    let point = |light: &light::Light| {
        let light = CheckedLight::new(light.clone()).expect("valid");
        let sample = reference.sample(&ReferenceLight::new(&light), &surface).expect("inside");
        let brightness = sample.irradiance.max_element() * surface.normal.dot(sample.coords.direction);
        let place = light.tube().and_then(|tube| tube.locate(at).point).expect("inside");
        (if sample.is_visible { brightness } else { 0.0 }, DVec2::new(place.v, place.w))
    };
    let was = point(trial.light.light());
    let free = point(&crate::drag(&scene.bvh, &trial.light, &drag, &[]).light);
    for kind in [PinKind::Look, PinKind::Coordinates] {
        let is_held = |(brightness, place): (f64, DVec2)| match kind {
            PinKind::Look => (brightness / was.0 - 1.0).abs() < 1e-5,
            _ => place.distance(was.1) < 1e-5,
        };
        let pin = DragPin { kind, at: PinTarget::Point(at), caster: None, is_hard: true };
        let result = crate::drag(&scene.bvh, &trial.light, &drag, &NumberedPin::by_index([pin]));
        assert_eq!(result.outcome.status, DragStatus::Landed, "{kind:?}");
        assert!(is_held(point(&result.light)), "{kind:?} {:?} {was:?}", point(&result.light));
        assert!(!is_held(free), "the planted fault: {kind:?} holds without a pin");
    }
}

/// A pin of a node holds too in a picture that does not show the node: one of the table from above.
///
/// Rules: DRAG-5
#[test]
fn a_pinned_node_need_not_be_in_the_picture() {
    let scene = support::demo();
    let reference = scene.reference();
    let trial = scene.trial_of_the_demo(None);
    let vase = NodePicture::new(&scene, &reference, &trial, "blue vase");
    let (shadow, _) = scene.tube_point(&trial.light, trial.drag.from).expect("the table");
    let camera = Camera {
        translation: shadow.position + scene.bvh.posed.origin_in_world + DVec3::Y,
        rotation: DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_2),
        ..trial.drag.view.camera.clone()
    };
    let view = Viewport { camera, ..trial.drag.view.clone() };
    let (from, to) = (DVec2::new(320.0, 180.0), DVec2::new(300.0, 230.0));
    let drag = Drag { view, from, to, points: Some(vec![1, 2, 3, 4]), ..trial.drag.clone() };
    let pin = DragPin { kind: PinKind::Look, at: PinTarget::Node("blue vase".into()), caster: None, is_hard: true };
    let run = |pins: &[NumberedPin]| crate::drag(&scene.bvh, &trial.light, &drag, pins);
    let (free, pinned) = (run(&[]), run(&NumberedPin::by_index([pin])));
    let off = [&free, &pinned].map(|result| vase.difference(trial.light.light(), &result.light));
    println!("{:?} {:?}, off by {off:.1?}", free.outcome.status, pinned.outcome.status);
    assert_ne!(pinned.light, *trial.light.light(), "{:?}", pinned.outcome);
    assert!(off[1] < 8.0 && off[0] > 8.0, "the second is the planted fault: {off:?}");
}

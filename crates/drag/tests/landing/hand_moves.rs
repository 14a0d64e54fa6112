//! Control points and lights moved by hand, which slide along hard pins.

use drag::{
    DragLimit, DragPin, NumberedPin, PinKind, PinTarget, RadiusMode, WorkBudget, first_broken_pin, place_along_pins,
    slide_point, slide_point_along_pins,
};
use glam::{DQuat, DVec2, DVec3};
use light::CheckedLight;
use light::parameters::{LIGHT_LINK, ROTATION, TRANSLATION};
use reference::Reference;

use crate::pins::{NodePicture, VisiblePin, pin_error, random_pins};
use crate::sliding::{covered_share, directions};
use crate::support::{self, Random, TestScene, Trial};

/// Largest error of a pin, in degrees or in pixels, as in `hard_pins_hold_wherever_the_drag_ends`.
fn most_error(pinned: &VisiblePin) -> f64 {
    if pinned.pin.kind == PinKind::Direction { 0.1 } else { 0.5 }
}

/// Test scene with the demo's light, and sets of hard pins that hold in it.
struct Pinned {
    scene: TestScene,
    trial: Trial,
    reference: Reference,
    sets: Vec<Vec<VisiblePin>>,
}

impl Pinned {
    /// Makes sets of one pin, of two and of three.
    fn new(count: usize) -> Self {
        let scene = support::demo();
        let (mut trial, reference) = (scene.trial_of_the_demo(None), scene.reference());
        // Random pixels are of this view.
        trial.drag.view = scene.view.clone();
        let mut random = Random(5);
        let mut set = |most: usize| {
            let mut pins = random_pins(&scene, &reference, &trial, &mut random);
            pins.truncate(most);
            for pinned in &mut pins {
                pinned.pin.is_hard = true;
            }
            pins
        };
        let sets = (0..count).map(|k| set(1 + k % 3)).collect();
        Self { scene, trial, reference, sets }
    }

    fn holds(&self, set: &[VisiblePin], light: &CheckedLight) -> bool {
        set.iter().all(|pinned| pin_error(&self.reference, &self.trial, pinned, light) < most_error(pinned))
    }

    /// True if no pin is broken as edits count it. A lit point also keeps half of its light.
    fn is_unbroken(&self, set: &[VisiblePin], light: &CheckedLight) -> bool {
        first_broken_pin(&self.scene.bvh, &self.trial.light, light, &numbered(set), &budget()).is_none()
    }
}

fn numbered(set: &[VisiblePin]) -> Vec<NumberedPin> {
    NumberedPin::by_index(set.iter().map(|pinned| pinned.pin.clone()))
}

fn budget() -> WorkBudget<'static> {
    WorkBudget::new(&|_| true)
}

/// Returns how far along a straight way the pins hold at every one of 64 places.
fn straight_share(holds: impl Fn(f64) -> bool) -> f64 {
    let held = (1..=64).take_while(|step| holds(f64::from(*step) / 64.0)).last();
    f64::from(held.unwrap_or(0)) / 64.0
}

/// With one to three pins, a control point that is dragged keeps the pins and comes at least as near as straight to the
/// first place where one breaks, and often nearer.
#[test]
fn control_points_slide_along_pins() {
    let pinned = Pinned::new(9);
    let light = &pinned.trial.light;
    let points = light.light().points();
    let length: f64 = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
    let (mut breaks_free, mut farther, mut limited, mut count) = (0, 0, 0, 0);
    for (k, set) in pinned.sets.iter().enumerate() {
        for (direction, point) in directions().skip(k % 4).step_by(4).zip((1..points.len()).cycle()) {
            let from = points[point].position;
            let to = from + direction * 0.3 * length;
            let slide = |pins: &[NumberedPin]| {
                let (bvh, radii) = (&pinned.scene.bvh, RadiusMode::Keep);
                slide_point_along_pins(bvh, light, point, to, radii, pins, &budget()).expect("a control point")
            };
            let slid = slide(&numbered(set));
            let what = || {
                format!("{point} {direction:.2} {:?} {:?}", slid.limit, set.iter().map(|p| &p.pin).collect::<Vec<_>>())
            };
            assert!(pinned.holds(set, &slid.light), "{}", what());
            let straight = straight_share(|share| {
                let moved = light.light().clone().map_point(point, |point| point.position = from.lerp(to, share));
                CheckedLight::new(moved).is_ok_and(|moved| pinned.is_unbroken(set, &moved))
            });
            let share = covered_share(from, slid.light.light().points()[point].position, to);
            // The slide keeps a thousandth of the light's length from the place where a pin breaks.
            assert!(share > straight - 1.0 / 64.0, "{share} {straight} {}", what());
            // The planted fault: without the pins one breaks.
            let free = slide_point(light, point, to, RadiusMode::Keep).expect("a control point");
            assert_eq!(slide(&[]), free, "{}", what());
            count += 1;
            breaks_free += usize::from(!pinned.holds(set, &free.light));
            limited += usize::from(matches!(slid.limit, Some(DragLimit::Pin(_))));
            farther += usize::from(share > straight + 1.0 / 32.0);
        }
    }
    println!("{count}: {breaks_free} would break a pin, {limited} limited by one, {farther} farther than straight");
    assert!(breaks_free * 3 > count && limited >= breaks_free && farther * 4 > count);
}

/// With one to three pins, a light that is placed keeps the pins, whether it moves, turns or both, and comes at least as
/// near as straight. What is not asked to change stays.
#[test]
fn placed_lights_slide_along_pins() {
    let pinned = Pinned::new(9);
    let light = &pinned.trial.light;
    let (from, turned_from) = (light.light().get(TRANSLATION), light.light().get(ROTATION));
    let (mut breaks_free, mut farther, mut limited, mut count) = (0, 0, 0, 0);
    for (k, set) in pinned.sets.iter().enumerate() {
        for (index, direction) in directions().skip(k % 4).step_by(4).enumerate() {
            let turn = DQuat::from_axis_angle(direction, 0.2);
            let translation = (index % 3 != 1).then_some(from + direction * 1.5);
            let rotation = (index % 3 != 0).then_some(turn * turned_from);
            let place = |pins: &[NumberedPin]| {
                place_along_pins(&pinned.scene.bvh, light, translation, rotation, pins, &budget()).expect("valid")
            };
            let (slid, free) = (place(&numbered(set)), place(&[]));
            let what = || format!("{translation:?} {rotation:?} {:?} {:?}", slid.limit, numbered(set));
            assert!(pinned.holds(set, &slid.light), "{}", what());
            let (now, turned) = (slid.light.light().get(TRANSLATION), slid.light.light().get(ROTATION));
            assert!(translation.is_some() || now == from, "{}", what());
            assert!(rotation.is_some() || turned == turned_from, "{}", what());
            assert_eq!(free.light.light().get(TRANSLATION), translation.unwrap_or(from));
            let share = match translation {
                Some(to) => covered_share(from, now, to),
                None => 1.0 - turned.angle_between(turn * turned_from) / 0.2,
            };
            let straight = straight_share(|share| {
                let to = translation.unwrap_or(from);
                let moved = light.light().clone().with(TRANSLATION, from.lerp(to, share));
                let turned =
                    rotation.map_or(turned_from, |_| DQuat::from_axis_angle(direction, 0.2 * share) * turned_from);
                CheckedLight::new(moved.with(ROTATION, turned)).is_ok_and(|moved| pinned.is_unbroken(set, &moved))
            });
            if index % 3 != 2 {
                assert!(share > straight - 1.0 / 64.0, "{share} {straight} {}", what());
            }
            count += 1;
            breaks_free += usize::from(!pinned.holds(set, &free.light));
            limited += usize::from(matches!(slid.limit, Some(DragLimit::Pin(_))));
            farther += usize::from(share > straight + 1.0 / 32.0);
        }
    }
    println!("{count}: {breaks_free} would break a pin, {limited} limited by one, {farther} farther than straight");
    assert!(breaks_free * 2 > count && limited >= breaks_free && farther * 4 > count);
}

/// Makes a hard pin of a kind.
fn hard(kind: PinKind, at: PinTarget) -> NumberedPin {
    NumberedPin { number: 7, pin: DragPin { kind, at, caster: None, is_hard: true } }
}

/// A look that is pinned on a node holds within 8 of 255 on nine in ten of its pixels, as seen from where the light
/// comes, while a control point slides, and the point does move. The points of the pin lie on the surface, since there
/// is no picture.
#[test]
fn control_points_slide_along_a_pinned_node() {
    let scene = support::demo();
    let (mut trial, reference) = (scene.trial_of_the_demo(None), scene.reference());
    let (seen, point) = scene.tube_point(&trial.light, DVec2::new(180.0, 160.0)).expect("the blue vase");
    let eye = &mut trial.drag.view.camera;
    eye.translation = seen.position + scene.bvh.posed.origin_in_world + point.direction * 4.0;
    eye.rotation = DQuat::from_rotation_arc(DVec3::Z, point.direction);
    let vase = NodePicture::new(&scene, &reference, &trial, "blue vase");
    let pins = [hard(PinKind::Look, PinTarget::Node("blue vase".into()))];
    let light = &trial.light;
    let (mut moved, mut differs_free) = (0, 0);
    for (direction, point) in directions().step_by(3).zip((2..5).cycle()) {
        let from = light.light().points()[point].position;
        let to = from + direction * 1.5;
        let slide = |pins: &[NumberedPin]| {
            slide_point_along_pins(&scene.bvh, light, point, to, RadiusMode::Keep, pins, &budget()).expect("a point")
        };
        let (slid, free) = (slide(&pins), slide(&[]));
        let off = [&free, &slid].map(|slide| vase.difference(light.light(), slide.light.light()));
        let way = slid.light.light().points()[point].position.distance(from);
        println!("{point} {direction:.2}: off by {off:.1?}, moved by {way:.3}");
        assert!(off[1] < 8.0, "{off:?}");
        moved += usize::from(way > 1e-3);
        differs_free += usize::from(off[0] > 8.0);
    }
    assert!(moved >= 4, "{moved} of 8 moved");
    assert!(differs_free >= 4, "the planted fault: without the pin the vase looks otherwise, and {differs_free} do");
}

/// A pin that does not hold before, and a soft one, limit nothing. Links that leave the pinned surface out break a pin
/// that holds.
#[test]
fn only_hard_pins_that_hold_can_break() {
    let scene = support::demo();
    let trial = scene.trial_of_the_demo(None);
    let light = &trial.light;
    let origin = scene.bvh.posed.origin_in_world;
    let outside = scene.seen(scene.outside(light)).expect("a surface").position + origin;
    let vase = scene.seen(DVec2::new(180.0, 160.0)).expect("the blue vase");
    let pin = |kind, at| hard(kind, PinTarget::Point(at));
    let held = pin(PinKind::Lit, vase.position + origin);
    let after = |links| CheckedLight::new(light.light().clone().with(LIGHT_LINK, links)).expect("valid");
    let path = scene.bvh.posed.node_tree().path(vase.node);
    let unlinked = after(light::Links::new(Vec::new(), vec![path]));
    let broken =
        |pins: &[NumberedPin], after: &CheckedLight| first_broken_pin(&scene.bvh, light, after, pins, &budget());
    assert_eq!(broken(std::slice::from_ref(&held), &unlinked), Some(7));
    assert_eq!(broken(std::slice::from_ref(&held), light), None);
    let soft = NumberedPin { pin: DragPin { is_hard: false, ..held.pin.clone() }, ..held };
    assert_eq!(broken(&[soft, pin(PinKind::Lit, outside)], &unlinked), None);
    let away = light.light().clone().with(TRANSLATION, DVec3::splat(100.0));
    let away = CheckedLight::new(away).expect("valid");
    assert_eq!(broken(&[pin(PinKind::Direction, outside)], &away), None);
    assert_eq!(broken(&[pin(PinKind::Direction, vase.position + origin)], &away), Some(7));
}

//! Hard pins that hold before an edit, checked with rays in the light after it.

use glam::DVec3;
use light::{CheckedLight, LightRays};
use raycast::Bvh;

use crate::occlusion::Occlusion;
use crate::overlap::OverlapRule;
use crate::pin_state::PinState;
use crate::pins::{Pins, node_named, nodes_under};
use crate::point_in_light::SceneLight;
use crate::request::{NumberedPin, PinKind, PinTarget};
use crate::visibility::{LEAST_SHARE_OF_NODE, Visibility};
use crate::work::WorkBudget;

/// Hard pins of a light that hold before an edit. Those that do not hold cannot limit it.
pub(crate) struct HeldPins<'a> {
    pub occlusion: &'a Occlusion<'a>,
    pins: Vec<HeldPin<'a>>,
}

/// One hard pin of a point or node.
struct HeldPin<'a> {
    pin: &'a NumberedPin,
    /// Light before the edit. An omni light has its chart about the pin, since a chart covers half of all directions.
    placed: SceneLight<'a>,
    states: Pins,
}

impl<'a> HeldPins<'a> {
    /// Selects the hard pins that hold in `light`, which `occlusion` belongs to.
    pub fn new(occlusion: &'a Occlusion<'a>, light: &'a CheckedLight, pins: &'a [NumberedPin]) -> Self {
        let origin = occlusion.bvh.posed.origin_in_world;
        let hard = pins.iter().filter(|pin| pin.pin.is_hard);
        let held = hard.filter_map(|pin| {
            let placed = SceneLight::new(light.rays(), origin, center(occlusion, light, pin), occlusion.work);
            let states = Pins::without_picture(occlusion, &placed, [pin]);
            (!states.states.is_empty()).then_some(HeldPin { pin, placed, states })
        });
        Self { occlusion, pins: held.collect() }
    }

    /// Returns the number of the first pin that does not hold in the light after the edit.
    pub fn first_broken(&self, after: &CheckedLight) -> Option<u64> {
        let (before, work) = (self.occlusion, self.occlusion.work);
        let now = Occlusion::new(before.bvh, after, work);
        let visibility = Visibility { occlusion: &now, source_outside: false, overlap: OverlapRule::default() };
        let is_broken = |held: &&HeldPin| {
            let placed = held.placed.with(after.rays());
            visibility.first_violated_pin(&placed, &held.states).is_some()
                || loses_link([before, &now], &held.states)
                // Rays that the budget cut short meet nothing, so what they say does not count.
                || work.is_exhausted()
        };
        self.pins.iter().find(is_broken).map(|held| held.pin.number)
    }

    /// Returns the light before the edit, and the states in it of all pins together. An omni light has its chart about
    /// the first pin, and pins in the other half of all directions are left out. `None` without pins.
    pub fn together(&self) -> Option<(SceneLight<'a>, Pins)> {
        let placed = self.pins.first()?.placed.clone();
        let pins = Pins::without_picture(self.occlusion, &placed, self.pins.iter().map(|held| held.pin));
        Some((placed, pins))
    }

    /// Returns the distance of the nearest pinned point from `source`, in world units; infinite without pins.
    pub fn nearest_distance(&self, source: DVec3) -> f64 {
        let points = self.pins.iter().flat_map(|held| &held.states.states).map(|state| state.point);
        points.map(|point| point.distance(source)).fold(f64::INFINITY, f64::min)
    }
}

/// Returns the number of the first hard pin that holds in the light `before` an edit and not in the light `after` it:
/// where light arrives, from where, and if something blocks it. Pins that do not hold before are passed over. Light
/// that links exclude does not arrive.
///
/// If `work` is spent, the pin that it is spent on counts as broken.
pub fn first_broken_pin(
    bvh: &Bvh,
    before: &CheckedLight,
    after: &CheckedLight,
    pins: &[NumberedPin],
    work: &WorkBudget,
) -> Option<u64> {
    let occlusion = Occlusion::new(bvh, before, work);
    HeldPins::new(&occlusion, before, pins).first_broken(after)
}

/// Returns a point that the chart of an omni light is made about, in scene space. Other lights have no use for it.
fn center(occlusion: &Occlusion, light: &CheckedLight, pin: &NumberedPin) -> DVec3 {
    match &pin.pin.at {
        PinTarget::Point(at) => at - occlusion.bvh.posed.origin_in_world,
        PinTarget::Node(node) if matches!(light.rays(), LightRays::Omni(_)) => {
            let root = node_named(&occlusion.bvh.posed, node);
            let is_of_node = root.and_then(|root| nodes_under(occlusion, root)).unwrap_or_default();
            let of_node = |node: usize| is_of_node.get(node).copied().unwrap_or_default();
            let triangles = occlusion.bvh.triangles().filter(|triangle| of_node(triangle.node));
            let corners = || triangles.clone().flat_map(|triangle| triangle.corners);
            corners().sum::<DVec3>() / (corners().count().max(1) as f64)
        }
        PinTarget::Node(_) => DVec3::ZERO,
    }
}

/// True if the links of the light after an edit exclude a pinned surface that they included before: more than a tenth
/// of a node's points. A pinned look also changes by the opposite.
fn loses_link([before, now]: [&Occlusion; 2], pins: &Pins) -> bool {
    let is_lost = |state: &&PinState| {
        let is_linked = |occlusion: &Occlusion| state.node.is_none_or(|node| occlusion.is_node_lit(node));
        match state.kind {
            PinKind::Look => is_linked(before) != is_linked(now),
            PinKind::Direction | PinKind::Lit => is_linked(before) && !is_linked(now),
            PinKind::Shadowed | PinKind::Shadow | PinKind::Coordinates => false,
        }
    };
    let kept = pins.states.len() - pins.states.iter().filter(is_lost).count();
    let least = if pins.nodes.is_empty() { 1.0 } else { LEAST_SHARE_OF_NODE };
    (kept as f64) < least * pins.states.len() as f64
}

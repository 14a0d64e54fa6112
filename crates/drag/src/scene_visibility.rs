//! Visibility constraints of a drag: occlusion of pinned points and surfaces before the source. Rays find them, since
//! they have no slope.

use glam::{DVec2, DVec3};

use crate::bound::cross_error;
use crate::goal::Goal;
use crate::moves::Unknowns;
use crate::occlusion::Occlusion;
use crate::pins::{OcclusionTangent, PinState};
use crate::point_in_light::SceneLight;
use crate::request::{DragLimit, PinKind};

/// Number of times that an interval is halved to find where a line first crosses a shadow edge.
const HALVINGS: usize = 40;

/// Most shadow edges that are added as limits at once. Solving with these may already resolve the others.
const EDGES_AT_ONCE: usize = 8;

/// Least distance of the source from a surface, as a share of the scene's size.
const SURFACE_CLEARANCE_SHARE: f64 = 1e-3;

/// Largest error in radii or radians at which an equation counts as fulfilled, if it is checked without the solver's
/// numbers.
const HELD_TOLERANCE: f64 = 1e-6;

/// Distance around an edge at which light paths probe its direction, in radii of the light.
const EDGE_PROBE_RADIUS: f64 = 1e-3;

/// Number of light paths that probe the direction of an edge.
const EDGE_PROBE_COUNT: usize = 16;

/// Scene against which the limits that depend on visibility are checked.
pub(crate) struct SceneVisibility<'a> {
    pub occlusion: &'a Occlusion<'a>,
    /// True if the source may not go through a surface.
    pub source_outside: bool,
}

impl SceneVisibility<'_> {
    /// Returns tangents of the shadow edges and surfaces that the light with the unknowns `x` has crossed, as limits
    /// for the next solve. Empty if it has crossed none. Checks soft pins too if `are_soft`.
    pub fn violated_tangents(&self, goal: &Goal, x: &[f64], are_soft: bool) -> Vec<OcclusionTangent> {
        let pins = self.violated_pins(goal, x, |pin| pin.is_hard || are_soft);
        let edges = pins.into_iter().filter_map(|pin| self.edge(goal, pin, x));
        let edges: Vec<OcclusionTangent> = edges.take(EDGES_AT_ONCE).collect();
        if edges.is_empty() { self.surface(goal, x).into_iter().collect() } else { edges }
    }

    /// Returns the first hard pin or surface that the light with the unknowns `x` violates.
    pub fn violated_limit(&self, goal: &Goal, x: &[f64]) -> Option<DragLimit> {
        let pins = self.violated_pins(goal, x, |pin| pin.is_hard);
        let pin = pins.first().map(|pin| DragLimit::Pin(pin.number));
        pin.or_else(|| self.surface(goal, x).map(|_| DragLimit::SourceInside))
    }

    /// Returns the pins of the selection that are not fulfilled in the light with the unknowns `x`.
    fn violated_pins<'g>(
        &self,
        goal: &'g Goal,
        x: &[f64],
        is_checked: impl Fn(&PinState) -> bool,
    ) -> Vec<&'g PinState> {
        let rays = goal.rays(x);
        let placed = rays.as_ref().map(|rays| goal.scene_light.with(rays));
        let is_held = |pin| placed.as_ref().is_some_and(|placed| self.is_pin_held(placed, pin) == Some(true));
        goal.pins.iter().filter(|pin| is_checked(pin) && !is_held(pin)).collect()
    }

    /// True if a pin is fulfilled in a light. Where paths of the light overlap, the root that counts decides. `None` if
    /// the point has no light coordinates.
    fn is_pin_held(&self, placed: &SceneLight, pin: &PinState) -> Option<bool> {
        let coords = placed.locate(pin.point, None)?;
        let is_held = match (pin.kind, pin.pivot) {
            (PinKind::Lit, _) => pin.is_lit(self.occlusion, placed, &coords),
            (PinKind::Shadow, Some((pivot, _))) => {
                let pivot = placed.locate(pivot, None)?;
                pivot.t < coords.t
                    && cross_error(pivot.cross_coords, &coords, &pin.start_coords).length() < HELD_TOLERANCE
            }
            (PinKind::Shadowed | PinKind::Shadow, _) => pin.is_shadowed(self.occlusion, placed, &coords),
            (PinKind::Direction, _) => coords.to_light.distance(pin.start_coords.to_light) < HELD_TOLERANCE,
        };
        Some(placed.contains(&coords) && is_held)
    }

    /// Finds the shadow edge that a pinned point crosses if the unknowns change in a straight line from the start to
    /// `x`.
    fn edge(&self, goal: &Goal, pin: &PinState, x: &[f64]) -> Option<OcclusionTangent> {
        let at = |share: f64| -> Vec<f64> { x.iter().map(|x| x * share).collect() };
        if !matches!(pin.kind, PinKind::Lit | PinKind::Shadowed) {
            return None;
        }
        let (mut holds, mut violated) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(holds, violated);
            let is_held = in_light(goal, &at(middle), |placed| self.is_pin_held(placed, pin)) == Some(true);
            if is_held { holds = middle } else { violated = middle }
        }
        let shadowed = if pin.kind == PinKind::Lit { violated } else { holds };
        in_light(goal, &at(shadowed), |placed| {
            let coords = pin.shadow_coords(placed, &placed.locate(pin.point, None)?)?;
            let first = |across: DVec2, contact| {
                self.occlusion.first_caster_on_path(placed, &coords, across, pin.shadow_point, contact, |_| true)
            };
            let caster = first(coords.cross_coords, pin.contact)?;
            // The pin's own surface, which neighbouring light paths meet too, does not count.
            let reach = EDGE_PROBE_RADIUS * pin.start_coords.width / coords.width;
            let mut contact = pin.contact;
            contact.within += 8.0 * reach * coords.width;
            let is_lit = |across: DVec2| first(across, contact).is_none();
            let allowed = (0..EDGE_PROBE_COUNT).map(|k| {
                let angle = std::f64::consts::TAU * k as f64 / EDGE_PROBE_COUNT as f64;
                let side = DVec2::new(libm::cos(angle), libm::sin(angle));
                let is_allowed = is_lit(coords.cross_coords + side * reach) == (pin.kind == PinKind::Lit);
                if is_allowed { side } else { -side }
            });
            let allowed = allowed.sum::<DVec2>().try_normalize()?;
            Some(OcclusionTangent::ShadowEdge { pin: pin.number, caster: caster.position, t: caster.t, allowed })
        })
    }

    /// Finds the surface that the source crosses on the straight line from the start of the drag to its position in the
    /// light with the unknowns `x`, and makes it a limit for the source. Shadow links are ignored.
    ///
    /// The source keeps a distance of a thousandth of the scene's size, or of half its distance at the start.
    fn surface(&self, goal: &Goal, x: &[f64]) -> Option<OcclusionTangent> {
        let Unknowns::Rigid { unit } = goal.unknowns else { return None };
        if !self.source_outside {
            return None;
        }
        let (from, offset) = (goal.scene_light.source(), DVec3::from_slice(&x[..3]) * unit);
        let bvh = self.occlusion.bvh;
        let size = bvh.posed.half_extent.length();
        // The ray is longer by the distance that the source keeps.
        let reach = 1.0 + SURFACE_CLEARANCE_SHARE * size / offset.length().max(f64::MIN_POSITIVE);
        let spend = |boxes| self.occlusion.work.spend_on_rays(boxes);
        let hit = bvh.first_hit_budgeted(from, offset, [0.0, reach], spend, |hit| {
            bvh.passes_alpha_test(&bvh.triangles[hit.triangle], hit.barycentrics)
        })?;
        let normal = bvh.triangles[hit.triangle].normal().normalize();
        let normal = if normal.dot(offset) < 0.0 { normal } else { -normal };
        let at = from + offset * hit.distance;
        let clearance = (SURFACE_CLEARANCE_SHARE * size).min(0.5 * (from - at).dot(normal));
        let is_clear = (from + offset - at).dot(normal) >= 0.99 * clearance;
        (!is_clear).then_some(OcclusionTangent::Surface { at, normal, clearance, size })
    }
}

/// Applies `what` to the light with the unknowns `x`, placed in the scene. `None` if the light cannot be evaluated.
fn in_light<T>(goal: &Goal, x: &[f64], what: impl Fn(&SceneLight) -> Option<T>) -> Option<T> {
    let rays = goal.rays(x)?;
    what(&goal.scene_light.with(&rays))
}

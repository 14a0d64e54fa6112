//! What is pinned by what light meets on its way, and where the source may go: found by rays, since it has no slope.

use glam::{DVec2, DVec3};

use crate::bound::cross_error;
use crate::goal::Goal;
use crate::moves::Unknowns;
use crate::occlusion::Occlusion;
use crate::pins::{OcclusionTangent, PinState};
use crate::point_in_light::SceneLight;
use crate::request::{DragLimit, PinKind};

/// Halvings by which the first crossing is found.
const HALVINGS: usize = 40;

/// Edges that are found at once. More wait for what these change.
const EDGES_AT_ONCE: usize = 8;

/// How far from a surface the source stays, in the scene's sizes.
const SURFACE_CLEARANCE_SHARE: f64 = 1e-3;

/// How far off an equation that holds may be where it is looked at anew, in radii or radians.
const HELD_TOLERANCE: f64 = 1e-6;

/// How far around an edge its direction is looked for, in radii of the light.
const EDGE_PROBE_RADIUS: f64 = 1e-3;

/// Ways that are followed there.
const EDGE_PROBE_COUNT: usize = 16;

/// The scene as what has to hold sees it.
pub(crate) struct SceneVisibility<'a> {
    pub occlusion: &'a Occlusion<'a>,
    /// Whether the source may not go through surfaces.
    pub source_outside: bool,
}

impl SceneVisibility<'_> {
    /// What the light with `x` breaks, as limits that keep it from that; none where all that has to hold does. `are_soft` looks at
    /// soft pins too.
    pub fn violated_tangents(&self, goal: &Goal, x: &[f64], are_soft: bool) -> Vec<OcclusionTangent> {
        let broken = self.violated_pins(goal, x, |pin| pin.is_hard || are_soft);
        let edges = broken.into_iter().filter_map(|pin| self.edge(goal, pin, x));
        let edges: Vec<OcclusionTangent> = edges.take(EDGES_AT_ONCE).collect();
        if edges.is_empty() { self.surface(goal, x).into_iter().collect() } else { edges }
    }

    /// What has to hold and does not in the light with `x`.
    pub fn violated_limit(&self, goal: &Goal, x: &[f64]) -> Option<DragLimit> {
        let pins = self.violated_pins(goal, x, |pin| pin.is_hard);
        let pin = pins.first().map(|pin| DragLimit::Pin(pin.index));
        pin.or_else(|| self.surface(goal, x).map(|_| DragLimit::SourceInside))
    }

    /// Of the pins that are looked at, those that do not hold in the light with `x`.
    fn violated_pins<'g>(
        &self,
        goal: &'g Goal,
        x: &[f64],
        is_looked_at: impl Fn(&PinState) -> bool,
    ) -> Vec<&'g PinState> {
        let looked_at = goal.pins.iter().filter(|pin| is_looked_at(pin));
        if let Some(rays) = goal.rays(x) {
            let placed = goal.scene_light.with(&rays);
            looked_at.filter(|pin| self.is_pin_held(&placed, pin) != Some(true)).collect()
        } else {
            looked_at.collect()
        }
    }

    /// Whether a pin holds in a light: where ways of it overlap, in the place that counts. `None` where it lies nowhere.
    fn is_pin_held(&self, placed: &SceneLight, pin: &PinState) -> Option<bool> {
        let place = placed.locate(pin.point, None)?;
        let is_inside = placed.rho2(&place) <= 1.0 && place.distance_to_ends >= 0.0;
        let is_held = match (pin.kind, pin.pivot) {
            (PinKind::Lit, _) => pin.is_lit(self.occlusion, placed, &place),
            (PinKind::Shadow, Some((pivot, _))) => {
                let pivot = placed.locate(pivot, None)?;
                pivot.t < place.t
                    && cross_error(pivot.cross_coords, &place, &pin.start_coords).length() < HELD_TOLERANCE
            }
            (PinKind::Shadowed | PinKind::Shadow, _) => pin.is_shadowed(self.occlusion, placed, &place),
            (PinKind::Direction, _) => place.to_light.distance(pin.start_coords.to_light) < HELD_TOLERANCE,
        };
        Some(is_inside && is_held)
    }

    /// The edge of the shadow that a pin crosses on the straight way to `x`.
    fn edge(&self, goal: &Goal, pin: &PinState, x: &[f64]) -> Option<OcclusionTangent> {
        let at = |share: f64| -> Vec<f64> { x.iter().map(|x| x * share).collect() };
        if !matches!(pin.kind, PinKind::Lit | PinKind::Shadowed) {
            return None;
        }
        let (mut holds, mut broken) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(holds, broken);
            let is_held = in_light(goal, &at(middle), |placed| self.is_pin_held(placed, pin)) == Some(true);
            if is_held { holds = middle } else { broken = middle }
        }
        let shadowed = if pin.kind == PinKind::Lit { broken } else { holds };
        in_light(goal, &at(shadowed), |placed| {
            let place = pin.shadow_coords(placed, &placed.locate(pin.point, None)?)?;
            let first = |across: DVec2, contact| {
                self.occlusion.first_caster_on_path(placed, &place, across, pin.shadow_point, contact)
            };
            let caster = first(place.cross_coords, pin.contact)?;
            // Its own surface, which ways beside it meet too, does not count.
            let reach = EDGE_PROBE_RADIUS * pin.start_coords.width / place.width;
            let mut contact = pin.contact;
            contact.within += 8.0 * reach * place.width;
            let is_lit = |across: DVec2| first(across, contact).is_none();
            let around = (0..EDGE_PROBE_COUNT).map(|way| {
                let angle = std::f64::consts::TAU * way as f64 / EDGE_PROBE_COUNT as f64;
                DVec2::new(libm::cos(angle), libm::sin(angle))
            });
            let allowed: DVec2 = around
                .map(|way| {
                    let is_allowed = is_lit(place.cross_coords + way * reach) == (pin.kind == PinKind::Lit);
                    if is_allowed { way } else { -way }
                })
                .sum();
            let allowed = allowed.try_normalize()?;
            Some(OcclusionTangent::ShadowEdge {
                pin: pin.index,
                caster: caster.position,
                t: caster.t,
                allowed,
            })
        })
    }

    /// The surface that the source goes through on its straight way in the light with `x`.
    fn surface(&self, goal: &Goal, x: &[f64]) -> Option<OcclusionTangent> {
        let Unknowns::Rigid { unit } = goal.unknowns else { return None };
        if !self.source_outside {
            return None;
        }
        let (from, way) = (goal.scene_light.source(), DVec3::from_slice(&x[..3]) * unit);
        self.surface_between(from, way)
    }

    /// The first surface on a way, whichever light it stops, as what the source may not go through. The source stays off it by
    /// a thousandth of the scene's size, or by half of how near it was.
    fn surface_between(&self, from: DVec3, way: DVec3) -> Option<OcclusionTangent> {
        let bvh = self.occlusion.bvh;
        let size = bvh.posed.half_extent.length();
        // As much farther as the source has to stay off.
        let reach = 1.0 + SURFACE_CLEARANCE_SHARE * size / way.length().max(f64::MIN_POSITIVE);
        let spend = |boxes| self.occlusion.work.spend_on_rays(boxes);
        let hit = bvh.first_hit_budgeted(from, way, [0.0, reach], spend, |hit| {
            bvh.passes_alpha_test(&bvh.triangles[hit.triangle], hit.barycentrics)
        })?;
        let normal = bvh.triangles[hit.triangle].normal().normalize();
        let normal = if normal.dot(way) < 0.0 { normal } else { -normal };
        let at = from + way * hit.distance;
        let off = (SURFACE_CLEARANCE_SHARE * size).min(0.5 * (from - at).dot(normal));
        let is_off = (from + way - at).dot(normal) >= 0.99 * off;
        (!is_off).then_some(OcclusionTangent::Surface { at, normal, clearance: off, size })
    }
}

/// What is so in the light with `x`, as it is placed in the scene.
fn in_light<T>(goal: &Goal, x: &[f64], what: impl Fn(&SceneLight) -> Option<T>) -> Option<T> {
    let rays = goal.rays(x)?;
    what(&goal.scene_light.with(&rays))
}

//! What is pinned by what light meets on its way, and where the source may go: found by rays, since it has no slope.

use glam::{DVec2, DVec3};

use crate::bound::across_off;
use crate::goal::Goal;
use crate::moves::Moves;
use crate::occlusion::Occlusion;
use crate::pins::{Cut, Pinned};
use crate::place::Placed;
use crate::request::{Limit, PinKind};

/// Halvings by which the first crossing is found.
const HALVINGS: usize = 40;

/// How far from a surface the source stays, in the scene's sizes.
const FROM_SURFACE: f64 = 1e-3;

/// How far off an equation that holds may be where it is looked at anew, in radii or radians.
const HELD: f64 = 1e-6;

/// How far around an edge its direction is looked for, in radii of the light.
const AROUND: f64 = 1e-3;

/// Ways that are followed there.
const WAYS: usize = 16;

/// The scene as what has to hold sees it.
pub(crate) struct Sight<'a> {
    pub occlusion: &'a Occlusion<'a>,
    /// Whether the source may not go through surfaces.
    pub source_outside: bool,
}

impl Sight<'_> {
    /// What the light with `x` breaks, as a limit that keeps it from that; `None` where all that has to hold does. `are_soft`
    /// looks at soft pins too.
    pub fn broken(&self, goal: &Goal, x: &[f64], are_soft: bool) -> Option<Cut> {
        let looked_at = goal.pins.iter().filter(|pin| pin.is_hard || are_soft);
        let broken =
            looked_at.filter(|pin| !self.holds(goal, pin, x)).find_map(|pin| self.edge(goal, pin, x));
        broken.or_else(|| self.surface(goal, x))
    }

    /// What has to hold and does not in the light with `x`.
    pub fn unheld(&self, goal: &Goal, x: &[f64]) -> Option<Limit> {
        let mut hard = goal.pins.iter().filter(|pin| pin.is_hard);
        let pin = hard.find(|pin| !self.holds(goal, pin, x)).map(|pin| Limit::Pin(pin.index));
        pin.or_else(|| self.surface(goal, x).map(|_| Limit::SourceInside))
    }

    /// Whether a pin holds in the light with `x`: where ways of the light overlap, in the place that counts.
    fn holds(&self, goal: &Goal, pin: &Pinned, x: &[f64]) -> bool {
        let holds = in_light(goal, x, |placed| {
            let place = placed.locate(pin.point, None)?;
            let is_inside = placed.out2(&place) <= 1.0 && place.from_ends >= 0.0;
            let is_held = match (pin.kind, pin.pivot) {
                (PinKind::Lit, _) => pin.is_lit(self.occlusion, placed, &place),
                (PinKind::Shadow, Some((pivot, _))) => {
                    let pivot = placed.locate(pivot, None)?;
                    pivot.t < place.t && across_off(pivot.across, &place, &pin.place).length() < HELD
                }
                (PinKind::Shadowed | PinKind::Shadow, _) => pin.is_shadowed(self.occlusion, placed, &place),
                (PinKind::Direction, _) => place.to_light.distance(pin.place.to_light) < HELD,
            };
            Some(is_inside && is_held)
        });
        holds == Some(true)
    }

    /// The edge of the shadow that a pin crosses on the straight way to `x`.
    fn edge(&self, goal: &Goal, pin: &Pinned, x: &[f64]) -> Option<Cut> {
        let at = |share: f64| -> Vec<f64> { x.iter().map(|x| x * share).collect() };
        if !matches!(pin.kind, PinKind::Lit | PinKind::Shadowed) {
            return None;
        }
        let (mut holds, mut broken) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(holds, broken);
            if self.holds(goal, pin, &at(middle)) { holds = middle } else { broken = middle }
        }
        let shadowed = if pin.kind == PinKind::Lit { broken } else { holds };
        in_light(goal, &at(shadowed), |placed| {
            let place = pin.shadow_place(placed, &placed.locate(pin.point, None)?)?;
            let first = |across: DVec2, contact| {
                self.occlusion.first_on(placed, &place, across, pin.shadow_point, contact)
            };
            let caster = first(place.across, pin.contact)?;
            // Its own surface, which ways beside it meet too, does not count.
            let reach = AROUND * pin.place.width / place.width;
            let mut contact = pin.contact;
            contact.within += 8.0 * reach * place.width;
            let is_lit = |across: DVec2| first(across, contact).is_none();
            let around = (0..WAYS).map(|way| {
                let angle = std::f64::consts::TAU * way as f64 / WAYS as f64;
                DVec2::new(libm::cos(angle), libm::sin(angle))
            });
            let allowed: DVec2 = around
                .map(|way| {
                    let is_allowed = is_lit(place.across + way * reach) == (pin.kind == PinKind::Lit);
                    if is_allowed { way } else { -way }
                })
                .sum();
            let allowed = allowed.try_normalize()?;
            Some(Cut::Edge { pin: pin.index, caster: caster.position, t: caster.t, allowed })
        })
    }

    /// The surface that the source goes through on its straight way in the light with `x`.
    fn surface(&self, goal: &Goal, x: &[f64]) -> Option<Cut> {
        let Moves::Rigid { unit } = goal.moves else { return None };
        if !self.source_outside {
            return None;
        }
        let (from, way) = (goal.placed.source(), DVec3::from_slice(&x[..3]) * unit);
        self.surface_between(from, way)
    }

    /// The first surface on a way, whichever light it stops, as what the source may not go through. The source stays off it by
    /// a thousandth of the scene's size, or by half of how near it was.
    fn surface_between(&self, from: DVec3, way: DVec3) -> Option<Cut> {
        let bvh = self.occlusion.bvh;
        let size = bvh.posed.half_extent.length();
        // As much farther as the source has to stay off.
        let reach = 1.0 + FROM_SURFACE * size / way.length().max(f64::MIN_POSITIVE);
        let hit = bvh.first_hit(from, way, [0.0, reach], |hit| {
            bvh.is_solid(&bvh.triangles[hit.triangle], hit.weights)
        })?;
        let normal = bvh.triangles[hit.triangle].normal().normalize();
        let normal = if normal.dot(way) < 0.0 { normal } else { -normal };
        let at = from + way * hit.distance;
        let off = (FROM_SURFACE * size).min(0.5 * (from - at).dot(normal));
        let is_off = (from + way - at).dot(normal) >= 0.99 * off;
        (!is_off).then_some(Cut::Surface { at, normal, off, size })
    }
}

/// What is so in the light with `x`, as it is placed in the scene.
fn in_light<T>(goal: &Goal, x: &[f64], what: impl Fn(&Placed) -> Option<T>) -> Option<T> {
    let rays = goal.moves.rays(goal.start, x)?;
    what(&goal.placed.with(&rays))
}

//! What is pinned by what light meets on its way, and where the source may go: found by rays, since it has no slope.

use glam::{DVec2, DVec3};

use crate::goal::Goal;
use crate::moves::Moves;
use crate::occlusion::Occlusion;
use crate::pins::{Cut, Pinned};
use crate::place::{Place, Placed};
use crate::request::PinKind;

/// Halvings by which the first crossing is found.
const HALVINGS: usize = 40;

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
        let broken = looked_at
            .filter(|pin| self.holds(goal, pin, x).is_none())
            .find_map(|pin| self.edge(goal, pin, x));
        broken.or_else(|| self.surface(goal, x))
    }

    /// Whether what has to hold does in the light with `x`.
    pub fn all_hold(&self, goal: &Goal, x: &[f64]) -> bool {
        goal.pins.iter().filter(|pin| pin.is_hard).all(|pin| self.holds(goal, pin, x).is_some())
            && self.surface(goal, x).is_none()
    }

    /// Where a pin is in the light with `x`, where it holds.
    fn holds(&self, goal: &Goal, pin: &Pinned, x: &[f64]) -> Option<Place> {
        let wanted = match pin.kind {
            PinKind::Lit => true,
            PinKind::Shadowed => false,
            // These are equations.
            PinKind::Direction | PinKind::Shadow => return Some(pin.place),
        };
        in_light(goal, x, |placed| {
            let place = placed.locate(pin.point, None)?;
            let is_inside = placed.out2(&place) <= 1.0 && place.from_ends >= 0.0;
            (is_inside && pin.is_lit(self.occlusion, placed, &place) == wanted).then_some(place)
        })
    }

    /// The edge of the shadow that a pin crosses on the straight way to `x`.
    fn edge(&self, goal: &Goal, pin: &Pinned, x: &[f64]) -> Option<Cut> {
        let at = |share: f64| -> Vec<f64> { x.iter().map(|x| x * share).collect() };
        let (mut holds, mut broken) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(holds, broken);
            if self.holds(goal, pin, &at(middle)).is_some() { holds = middle } else { broken = middle }
        }
        let shadowed = if pin.kind == PinKind::Lit { broken } else { holds };
        in_light(goal, &at(shadowed), |placed| {
            let place = placed.locate(pin.point, None)?;
            let first =
                |across: DVec2, contact| self.occlusion.first_on(placed, &place, across, pin.point, contact);
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
        self.occlusion.surface_between(from, way)
    }
}

/// What is so in the light with `x`, as it is placed in the scene.
fn in_light<T>(goal: &Goal, x: &[f64], what: impl Fn(&Placed) -> Option<T>) -> Option<T> {
    let rays = goal.moves.rays(goal.start, x)?;
    what(&goal.placed.with(&rays))
}

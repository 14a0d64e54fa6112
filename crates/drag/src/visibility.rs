//! Limits of a drag without a slope: occlusion of pinned points, surfaces before the source, and overlaps of the tube.

use glam::{DVec2, DVec3};

use crate::bound::cross_error;
use crate::moves::Unknowns;
use crate::occlusion::Occlusion;
use crate::overlap::OverlapRule;
use crate::pin_state::{LimitTangent, PinState};
use crate::pins::{NodePin, Pins};
use crate::point_in_light::SceneLight;
use crate::problem::Problem;
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

/// Least share of the points of a pinned node that must look as before. They do within 6 steps of 255 of the brightness
/// that displays show, so that nine in ten of all its pixels do within 8, and within an angle in radians or a distance in
/// radii.
pub(crate) const LEAST_SHARE_OF_NODE: f64 = 0.9;
const NODE_BRIGHTNESS: f64 = 6.0 / 255.0;
const NODE_TURN: f64 = 0.05;

/// Distance around an edge at which light paths probe its direction, in radii of the light.
const EDGE_PROBE_RADIUS: f64 = 1e-3;

/// Number of light paths that probe the direction of an edge.
const EDGE_PROBE_COUNT: usize = 16;

/// Scene and rules against which the limits without a slope are checked.
pub(crate) struct Visibility<'a> {
    pub occlusion: &'a Occlusion<'a>,
    /// True if the source may not go through a surface.
    pub source_outside: bool,
    pub overlap: OverlapRule,
}

impl Visibility<'_> {
    /// Returns tangents of the limits that the light with the unknowns `x` has crossed, for the next solve. Empty if it
    /// has crossed none. Checks soft pins too if `are_soft`.
    pub fn violated_tangents(&self, problem: &Problem, x: &[f64], are_soft: bool) -> Vec<LimitTangent> {
        let pins = self.violated_pins(problem, x, |pin| pin.is_hard() || (are_soft && !pin.is_of_node));
        let edges = pins.into_iter().filter_map(|pin| self.edge(problem, pin, x));
        let edges: Vec<LimitTangent> = edges.take(EDGES_AT_ONCE).collect();
        if !edges.is_empty() {
            return edges;
        }
        let met = || problem.first_overlap(self.overlap, x).map(LimitTangent::Overlap);
        self.surface(problem, x).or_else(met).into_iter().collect()
    }

    /// Returns the first limit that the light with the unknowns `x` violates.
    pub fn violated_limit(&self, problem: &Problem, x: &[f64]) -> Option<DragLimit> {
        let pins = self.violated_pins(problem, x, PinState::is_hard);
        let node = || in_light(problem, x, |placed| self.first_violated_node(placed, problem.pins));
        let pin = pins.first().map(|pin| pin.number).or_else(node).map(DragLimit::Pin);
        let overlaps = || problem.rays(x).and_then(|rays| self.overlap.overlap(&rays, problem.work()));
        pin.or_else(|| self.surface(problem, x).map(|_| DragLimit::SourceInside))
            .or_else(|| overlaps().map(|_| DragLimit::Overlap))
    }

    /// Returns the pins of the selection that are not fulfilled in the light with the unknowns `x`.
    fn violated_pins<'g>(
        &self,
        problem: &Problem<'g>,
        x: &[f64],
        is_checked: impl Fn(&PinState) -> bool,
    ) -> Vec<&'g PinState> {
        let rays = problem.rays(x);
        let placed = rays.as_ref().map(|rays| problem.scene_light.with(rays));
        let is_held = |pin| placed.as_ref().is_some_and(|placed| self.is_pin_held(placed, pin) == Some(true));
        problem.pins.states.iter().filter(|pin| is_checked(pin) && !is_held(pin)).collect()
    }

    /// Returns the number of the first hard pin that does not hold in a light.
    pub fn first_violated_pin(&self, placed: &SceneLight, pins: &Pins) -> Option<u64> {
        let is_violated = |pin: &&PinState| pin.is_hard() && self.is_pin_held(placed, pin) != Some(true);
        let violated = pins.states.iter().find(is_violated).map(|pin| pin.number);
        violated.or_else(|| self.first_violated_node(placed, pins))
    }

    /// Returns the number of the first hard pin of a node that does not hold in a light: on at least a tenth of its
    /// points.
    pub fn first_violated_node(&self, placed: &SceneLight, pins: &Pins) -> Option<u64> {
        let is_held = |node: &NodePin| {
            let states = &pins.states[node.states.clone()];
            let brightest = states.iter().map(PinState::start_brightness).fold(0.0, f64::max);
            let held = states.iter().filter(|pin| self.looks_held(placed, pin, brightest) == Some(true)).count();
            held as f64 >= LEAST_SHARE_OF_NODE * states.len() as f64
        };
        pins.nodes.iter().find(|node| !is_held(node)).map(|node| node.number)
    }

    /// Returns the largest change, from the first light to the second, of what a picture shows at a point of a hard pin of
    /// a node: 0 to 1, where 1 is the brightness of the pin's brightest point at the start of the drag. `None` without such
    /// a pin.
    pub fn largest_change_of_nodes(&self, lights: [&SceneLight; 2], pins: &Pins) -> Option<f64> {
        let arriving = |light: &SceneLight, pin: &PinState| {
            let coords = light.locate(pin.point, None).filter(|coords| light.contains(coords))?;
            let is_lit = pin.is_lit(self.occlusion, light, &coords);
            if is_lit { pin.brightness(light, &coords) } else { None }
        };
        let of_node = |node: &NodePin| {
            let states = &pins.states[node.states.clone()];
            let brightness = lights.map(|light| -> Vec<f64> {
                states.iter().map(|pin| arriving(light, pin).unwrap_or_default()).collect()
            });
            let brightest = brightness[0].iter().copied().fold(f64::MIN_POSITIVE, f64::max);
            let [before, after] =
                brightness.map(|brightness| brightness.into_iter().map(move |b| shown(b / brightest)));
            before.zip(after).map(|(before, after)| (after.min(1.0) - before).abs()).fold(0.0, f64::max)
        };
        pins.nodes.iter().map(of_node).reduce(f64::max)
    }

    /// True if one of many points of a pin looks as before. `brightest` is the irradiance of the brightest of them. `None`
    /// if the point has no light coordinates.
    fn looks_held(&self, placed: &SceneLight, pin: &PinState, brightest: f64) -> Option<bool> {
        let coords = placed.locate(pin.point, None)?;
        let turn = coords.to_light.distance(pin.start_coords.to_light);
        let (now, was) = (pin.brightness(placed, &coords)?, pin.start_brightness());
        let shown = |brightness: f64| shown(brightness / brightest.max(f64::MIN_POSITIVE));
        let is_held = match (pin.kind, pin.stays_lit) {
            (PinKind::Direction, _) => turn < NODE_TURN,
            (PinKind::Look, Some(true)) => {
                (shown(now) - shown(was)).abs() < NODE_BRIGHTNESS && pin.is_lit(self.occlusion, placed, &coords)
            }
            (PinKind::Look, _) => !pin.is_lit(self.occlusion, placed, &coords),
            (PinKind::Lit, _) => pin.keeps_light(placed, &coords)? && pin.is_lit(self.occlusion, placed, &coords),
            (PinKind::Shadowed, _) => pin.is_shadowed(self.occlusion, placed, &coords),
            (PinKind::Shadow | PinKind::Coordinates, _) => {
                let across = match pin.pivot {
                    Some((pivot, _)) => placed.locate(pivot, None)?.cross_coords,
                    None => pin.start_coords.cross_coords,
                };
                cross_error(across, &coords, &pin.start_coords).length() < NODE_TURN
            }
        };
        Some(is_held)
    }

    /// True if a pin is fulfilled in a light. Where paths of the light overlap, the root that counts decides. `None` if
    /// the point has no light coordinates.
    fn is_pin_held(&self, placed: &SceneLight, pin: &PinState) -> Option<bool> {
        let coords = placed.locate(pin.point, None)?;
        let is_from_there = || coords.to_light.distance(pin.start_coords.to_light) < HELD_TOLERANCE;
        let is_held = match (pin.kind, pin.pivot) {
            (PinKind::Lit, _) => pin.keeps_light(placed, &coords)? && pin.is_lit(self.occlusion, placed, &coords),
            (PinKind::Shadow, Some((pivot, _))) => {
                let pivot = placed.locate(pivot, None)?;
                pivot.t < coords.t
                    && cross_error(pivot.cross_coords, &coords, &pin.start_coords).length() < HELD_TOLERANCE
            }
            (PinKind::Shadowed | PinKind::Shadow, _) => pin.is_shadowed(self.occlusion, placed, &coords),
            (PinKind::Direction, _) => is_from_there(),
            (PinKind::Look, _) => {
                let is_lit = pin.is_lit(self.occlusion, placed, &coords);
                let (now, was) = (pin.brightness(placed, &coords)?, pin.start_brightness());
                is_from_there() && Some(is_lit) == pin.stays_lit && (now - was).abs() <= HELD_TOLERANCE * was
            }
            (PinKind::Coordinates, _) => {
                cross_error(pin.start_coords.cross_coords, &coords, &pin.start_coords).length() < HELD_TOLERANCE
            }
        };
        Some(placed.contains(&coords) && is_held)
    }

    /// Finds the shadow edge that a pinned point crosses if the unknowns change in a straight line from the start to
    /// `x`.
    fn edge(&self, problem: &Problem, pin: &PinState, x: &[f64]) -> Option<LimitTangent> {
        let at = |share: f64| -> Vec<f64> { x.iter().map(|x| x * share).collect() };
        let stays_lit = pin.stays_lit?;
        let (mut holds, mut violated) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(holds, violated);
            let is_held = in_light(problem, &at(middle), |placed| self.is_pin_held(placed, pin)) == Some(true);
            if is_held { holds = middle } else { violated = middle }
        }
        let shadowed = if stays_lit { violated } else { holds };
        in_light(problem, &at(shadowed), |placed| {
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
                let is_allowed = is_lit(coords.cross_coords + side * reach) == stays_lit;
                if is_allowed { side } else { -side }
            });
            let allowed = allowed.sum::<DVec2>().try_normalize()?;
            Some(LimitTangent::ShadowEdge { pin: pin.number, caster: caster.position, t: caster.t, allowed })
        })
    }

    /// Finds the surface that the source crosses in the light with the unknowns `x`, as `crossed_surface` does.
    fn surface(&self, problem: &Problem, x: &[f64]) -> Option<LimitTangent> {
        let Unknowns::Rigid { unit } = *problem.unknowns else { return None };
        self.crossed_surface(problem.scene_light.source(), DVec3::from_slice(&x[..3]) * unit)
    }

    /// Finds the surface that the source crosses on the straight line from its position at the start of the drag, and
    /// makes it a limit for the source. Shadow links are ignored. `None` if the source may go through surfaces.
    ///
    /// The source keeps a distance of a thousandth of the scene's size, or of half its distance at the start.
    pub fn crossed_surface(&self, from: DVec3, offset: DVec3) -> Option<LimitTangent> {
        if !self.source_outside {
            return None;
        }
        let bvh = self.occlusion.bvh;
        let size = bvh.posed.half_extent.length();
        // The ray is longer by the distance that the source keeps.
        let reach = 1.0 + SURFACE_CLEARANCE_SHARE * size / offset.length().max(f64::MIN_POSITIVE);
        let spend = |boxes| self.occlusion.work.spend_on_rays(boxes);
        let hit = bvh.first_hit_budgeted(from, offset, [0.0, reach], spend, |hit| {
            bvh.passes_alpha_test(&bvh.triangle(hit.triangle), hit.barycentrics)
        })?;
        let normal = bvh.triangle(hit.triangle).normal().normalize();
        let normal = if normal.dot(offset) < 0.0 { normal } else { -normal };
        let at = from + offset * hit.distance;
        let clearance = (SURFACE_CLEARANCE_SHARE * size).min(0.5 * (from - at).dot(normal));
        let is_clear = (from + offset - at).dot(normal) >= 0.99 * clearance;
        (!is_clear).then_some(LimitTangent::Surface { at, normal, clearance, size })
    }
}

/// Returns the brightness that a display shows, by sRGB but for its straight part near 0.
fn shown(brightness: f64) -> f64 {
    1.055 * libm::pow(brightness, 1.0 / 2.4)
}

/// Applies `what` to the light with the unknowns `x`, placed in the scene. `None` if the light cannot be evaluated.
fn in_light<T>(problem: &Problem, x: &[f64], what: impl Fn(&SceneLight) -> Option<T>) -> Option<T> {
    let rays = problem.rays(x)?;
    what(&problem.scene_light.with(&rays))
}

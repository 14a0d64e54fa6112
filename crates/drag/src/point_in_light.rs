//! Light coordinates of a point, for every shape of light, tracked while the light moves.

use glam::{DVec2, DVec3};
use light::{EndMode, LightRays, Tube, TubeRoot};

use crate::work::WorkBudget;

/// Costs of locating a point, in steps of the work budget. This one is for a point that is tracked in a tube. The next
/// ones are for any other light, and for a search in one segment of a tube.
const STEPS_OF_PLACE: u64 = 300;
const STEPS_OF_STRAIGHT_PLACE: u64 = 60;
const STEPS_OF_ROOT: u64 = 50;

/// Samples of a segment in the search for the part of a tube that is nearest to a point outside, and the cost of one.
const SAMPLES_OF_SEGMENT: usize = 4;
const STEPS_OF_SAMPLE: u64 = 10;

/// Light coordinates of a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointInLight {
    /// Distance along the light path, growing from the source: t of a tube, a length in world units for other shapes.
    pub t: f64,
    /// Light path of the point: (v, w) of a tube or cone, coordinates across the light for other shapes.
    pub cross_coords: DVec2,
    /// World units per unit of `cross_coords` at the point.
    pub width: f64,
    /// Unit vector towards the direction from which light arrives.
    pub to_light: DVec3,
    /// Unit vector back along the light path, which decides visibility: for a tube the tangent of the path.
    pub along_path: DVec3,
    /// For a tube `1 - kappa r.N`, which is 0 where light paths meet; else 1.
    pub path_spacing: f64,
    /// Distance from the light's ends in widths, negative beyond one; infinite if the light has none.
    pub distance_to_ends: f64,
}

/// Axes for directions of an omni light near one direction, in the light's axes. A direction's `cross_coords` are its
/// gnomonic coordinates along these axes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chart {
    ahead: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Chart {
    /// Makes the chart about the unit vector `ahead`.
    pub fn about(ahead: DVec3) -> Self {
        let right = ahead.any_orthonormal_vector();
        Self { ahead, right, up: right.cross(ahead) }
    }

    /// Returns the direction at `across`, in the light's axes.
    pub fn direction_at(&self, across: DVec2) -> DVec3 {
        self.ahead + self.right * across.x + self.up * across.y
    }
}

/// Light as rays relative to the origin of scene space.
#[derive(Clone, Debug)]
pub(crate) struct SceneLight<'a> {
    pub rays: &'a LightRays,
    /// Origin of scene space, in the world.
    pub origin_in_world: DVec3,
    /// Axes for directions of an omni light.
    pub chart: Chart,
    /// Budget for locating points.
    pub work: &'a WorkBudget<'a>,
}

impl<'a> SceneLight<'a> {
    /// Places `rays` in a scene. The chart of an omni light is about the direction to `about`.
    pub fn new(rays: &'a LightRays, origin_in_world: DVec3, about: DVec3, work: &'a WorkBudget<'a>) -> Self {
        let ahead = match rays {
            LightRays::Omni(omni) => {
                omni.rotation.transpose() * (about - (omni.translation - origin_in_world)).normalize_or(DVec3::Z)
            }
            _ => DVec3::Z,
        };
        Self { rays, origin_in_world, chart: Chart::about(ahead), work }
    }

    /// Copies the light with other rays of the same shape.
    pub fn with(&self, rays: &'a LightRays) -> Self {
        Self { rays, ..*self }
    }

    /// Returns the position of the source in scene space; for a directional light any point of its axis.
    pub fn source(&self) -> DVec3 {
        let in_world = match self.rays {
            LightRays::Bent(tube) => tube.placement.translation,
            LightRays::Cone(cone) => cone.translation,
            LightRays::Omni(omni) => omni.translation,
            LightRays::Parallel(parallel) => parallel.translation,
        };
        in_world - self.origin_in_world
    }

    /// Returns the cost of locating a point, in steps: of a tracked point if `is_tracked`, else of a search in all
    /// segments.
    fn locate_cost_steps(&self, is_tracked: bool) -> u64 {
        match self.rays {
            LightRays::Bent(tube) if !is_tracked => STEPS_OF_ROOT * tube.segments.len() as u64,
            LightRays::Bent(_) => STEPS_OF_PLACE,
            LightRays::Cone(_) | LightRays::Omni(_) | LightRays::Parallel(_) => STEPS_OF_STRAIGHT_PLACE,
        }
    }

    /// Computes the light coordinates of a point in scene space, inside the light or beside it. In a tube it tracks the
    /// root from `near`, or without `near` takes the root that counts.
    ///
    /// `None` behind a source, outside a tube without `near`, and if the budget is spent.
    pub fn locate(&self, point: DVec3, near: Option<f64>) -> Option<PointInLight> {
        if !self.work.spend(self.locate_cost_steps(near.is_some())) {
            return None;
        }
        let from_source = point - self.source();
        match self.rays {
            LightRays::Bent(tube) => {
                let q = tube_from_source(tube, from_source);
                let root = near.map_or_else(|| tube.nearest_root(q), |t| Some(track_root(tube, q, t)))?;
                Some(tube_coords(tube, &root))
            }
            LightRays::Cone(cone) => {
                let local = cone.rotation.transpose() * from_source;
                let depth = -local.z;
                let across = DVec2::new(-local.x, local.y) / (depth * cone.tan_outer);
                let width = depth * cone.tan_outer;
                let from_ends = cone.range.map_or(f64::INFINITY, |range| (range - depth) / width);
                (depth > 0.0).then(|| straight_coords(from_source, across, width, from_ends))
            }
            LightRays::Omni(omni) => {
                let (local, chart) = (omni.rotation.transpose() * from_source, self.chart);
                let ahead = local.dot(chart.ahead);
                let across = DVec2::new(local.dot(chart.right), local.dot(chart.up)) / ahead;
                let from_ends = omni.range.map_or(f64::INFINITY, |range| (range - from_source.length()) / ahead);
                (ahead > 0.0).then(|| straight_coords(from_source, across, ahead, from_ends))
            }
            LightRays::Parallel(parallel) => {
                let local = parallel.rotation.transpose() * from_source;
                let across = DVec2::new(-local.x, local.y);
                let coords = straight_coords(from_source, across, 1.0, f64::INFINITY);
                let to_light = parallel.direction();
                Some(PointInLight { t: -local.z, to_light, along_path: to_light, ..coords })
            }
        }
    }

    /// Returns `t` of the light's axis nearest to a point, in radii, whether or not the light contains the point. `None`
    /// behind a source.
    pub fn nearest_t(&self, point: DVec3) -> Option<f64> {
        let LightRays::Bent(tube) = self.rays else { return self.locate(point, None).map(|coords| coords.t) };
        if let Some(coords) = self.locate(point, None) {
            return Some(coords.t);
        }
        let q = tube_from_source(tube, point - self.source());
        let count = SAMPLES_OF_SEGMENT * tube.segments.len();
        if !self.work.spend(STEPS_OF_SAMPLE * count as u64) {
            return None;
        }
        let distance = |sample: usize| {
            let t = (sample as f64 + 0.5) / SAMPLES_OF_SEGMENT as f64;
            let (segment, u) = tube.segment_at(t);
            let curve = &tube.segments[segment].curve;
            (curve.offset(q, u).length() / curve.radius(u).max(f64::MIN_POSITIVE), t)
        };
        (0..count).map(distance).min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, t)| t)
    }

    /// Computes the light coordinates, and the largest component of the unshadowed irradiance on a surface orthogonal
    /// to the light there. Outside the light's edge it is the irradiance at the edge.
    pub fn locate_with_edge_irradiance(&self, point: DVec3, near: f64) -> Option<(PointInLight, f64)> {
        const EDGE: f64 = 0.999;
        let inside = |across: DVec2| across * (EDGE / across.length()).min(1.0);
        let from_source = point - self.source();
        let (coords, across, path_length, emission) = if let LightRays::Bent(tube) = self.rays {
            if !self.work.spend(self.locate_cost_steps(true)) {
                return None;
            }
            let root = track_root(tube, tube_from_source(tube, from_source), near);
            let coords = tube_coords(tube, &root);
            let emission = tube.segments[root.segment].emission(root.u);
            (coords, inside(coords.cross_coords), tube.path_length(&root), emission)
        } else {
            let coords = self.locate(point, Some(near))?;
            let (across, path_length) = match self.rays {
                LightRays::Cone(_) => (inside(coords.cross_coords), from_source.length()),
                LightRays::Omni(omni) => {
                    let on_cube = omni.locate(from_source).map_or(DVec2::ZERO, |coords| DVec2::new(coords.v, coords.w));
                    (on_cube, from_source.length())
                }
                _ => (DVec2::ZERO, 0.0),
            };
            (coords, across, path_length, DVec3::ONE)
        };
        let profile = self.rays.light_profile();
        let attenuation: f64 = profile.attenuation_at(across.x, across.y, path_length);
        Some((coords, (emission * profile.tint).max_element() * attenuation))
    }

    /// Returns the profile at coordinates across the light, 0 to 1. Outside the light's edge it is that at the edge.
    pub fn edge_profile(&self, coords: &PointInLight) -> f64 {
        const EDGE: f64 = 0.999;
        let across = coords.cross_coords * (EDGE / coords.cross_coords.length()).min(1.0);
        match self.rays {
            LightRays::Bent(_) | LightRays::Cone(_) => self.rays.light_profile().across(across.x, across.y),
            LightRays::Omni(_) | LightRays::Parallel(_) => 1.0,
        }
    }

    /// Returns the light path at `across` of a light without a tube: its start, and its point level with `point` at
    /// `coords`. The path of a directional light starts at the distance `far` before that point.
    pub fn straight_path(&self, coords: &PointInLight, across: DVec2, point: DVec3, far: f64) -> (DVec3, DVec3) {
        let source = self.source();
        let level = |offset: DVec3| (source, source + offset);
        match self.rays {
            LightRays::Cone(cone) => {
                let depth = coords.width / cone.tan_outer;
                level(cone.rotation * DVec3::new(-across.x * coords.width, across.y * coords.width, -depth))
            }
            LightRays::Omni(omni) => level(omni.rotation * self.chart.direction_at(across) * coords.width),
            LightRays::Parallel(parallel) => {
                let beside = across - coords.cross_coords;
                let to = point + parallel.rotation * DVec3::new(-beside.x, beside.y, 0.0);
                (to + parallel.direction() * far, to)
            }
            LightRays::Bent(_) => level(DVec3::ZERO),
        }
    }

    /// True if the point lies within the light's cross-section and between its ends.
    pub fn contains(&self, coords: &PointInLight) -> bool {
        self.rho2(coords) <= 1.0 && coords.distance_to_ends >= 0.0
    }

    /// Returns the squared distance of the point from the light's axis, which is 1 at the light's edge. It is 0 for a
    /// light without an edge.
    pub fn rho2(&self, coords: &PointInLight) -> f64 {
        match self.rays {
            LightRays::Bent(_) | LightRays::Cone(_) => coords.cross_coords.length_squared(),
            LightRays::Omni(_) => 0.0,
            LightRays::Parallel(parallel) => {
                let share = |along: f64, half: Option<f64>| half.map_or(0.0, |half| (along / half).abs());
                let out = share(coords.cross_coords.x, parallel.half_size[0])
                    .max(share(coords.cross_coords.y, parallel.half_size[1]));
                out * out
            }
        }
    }
}

/// Converts an offset from the source, in world axes, to tube space.
fn tube_from_source(tube: &Tube<f64>, from_source: DVec3) -> DVec3 {
    tube.placement.rotation.transpose() * from_source / tube.placement.world_per_tube
}

/// Tracks the root near `t` regardless of the radius, by Newton's method on `(q - P) . P'`, a cubic in each segment. Near
/// the root it takes Halley's steps: the error after one is the cube of the one before.
pub(crate) fn track_root(tube: &Tube<f64>, q: DVec3, near: f64) -> TubeRoot<f64> {
    const STEPS: usize = 12;
    // Steps after which the error is some 1e-15, by Newton's method and by Halley's. A slope by differences moves a root
    // by less than the second, so that it takes one step.
    const LAST_STEPS: [f64; 2] = [1e-9, 1e-5];
    // Largest relative difference between the steps. Beyond it the second derivative may lead to another root.
    const NEAR: f64 = 0.1;
    let end = tube.t_end();
    let mut t = near.clamp(0.0, end);
    for _ in 0..STEPS {
        let (segment, u) = tube.segment_at(t);
        let curve = &tube.segments[segment].curve;
        let (r, d) = (curve.offset(q, u), curve.d(u));
        let slope = 2.0 * d.length_squared() - r.dot(curve.a);
        if slope <= 0.0 {
            break;
        }
        let newton = r.dot(d) / slope;
        let bend = 3.0 * newton * d.dot(curve.a) / slope;
        let is_near = bend.abs() < NEAR;
        let step = if is_near { newton / (1.0 + bend) } else { newton };
        // The curve changes past a joint, so a step is at most one segment long, and is not the last past one.
        let next = (t + step.clamp(-1.0, 1.0)).clamp(0.0, end);
        let last = LAST_STEPS[usize::from(is_near)] * (1.0 + t);
        let is_done = (next - t).abs() <= last && tube.segment_at(next).0 == segment;
        t = next;
        if is_done {
            break;
        }
    }
    let (segment, u) = tube.segment_at(t);
    tube.root_at(&tube.inside_at(segment, q, u).0)
}

/// Makes the coordinates of a point that light reaches along the straight `path`.
fn straight_coords(path: DVec3, cross_coords: DVec2, width: f64, distance_to_ends: f64) -> PointInLight {
    let t = path.length();
    let to_light = -path / t;
    PointInLight { t, cross_coords, width, to_light, along_path: to_light, path_spacing: 1.0, distance_to_ends }
}

/// Makes the coordinates of a root of a tube.
fn tube_coords(tube: &Tube<f64>, root: &TubeRoot<f64>) -> PointInLight {
    let curve = &tube.segments[root.segment].curve;
    let turn = curve.u_hat_derivative(root.u, root.u_hat);
    let speed = 2.0 * curve.d(root.u).length();
    let scale = tube.placement.world_per_tube;
    let radius = if root.radius > 0.0 { root.radius } else { 1.0 };
    // Beyond an end `r` has a component along the tangent.
    let beyond = root.r.dot(root.u_hat) / radius;
    let is_endless = tube.end_mode() == EndMode::Extend;
    let from_end = if is_endless { f64::INFINITY } else { (tube.n as f64 - root.t()) * speed / radius - beyond };
    let from_source = root.t() * speed / radius + beyond;
    PointInLight {
        t: root.t(),
        cross_coords: DVec2::new(root.v_len, root.w_len) / radius,
        width: radius * scale,
        to_light: tube.placement.rotation * tube.direction_at(root),
        along_path: tube.placement.rotation * tube.path_direction_at(root),
        path_spacing: if speed > 0.0 { 1.0 - root.r.dot(turn) / speed } else { 0.0 },
        distance_to_ends: from_end.min(from_source),
    }
}

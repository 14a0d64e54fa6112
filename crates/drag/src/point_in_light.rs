//! Where a point lies in a light, whatever its shape, followed while the light moves.

use glam::{DVec2, DVec3};
use light::{LightRays, Tube, TubeRoot};

use crate::work::WorkBudget;

/// Steps of finding a place: one that is followed in a tube, one in any other light, and one that is looked for in a segment.
const STEPS_OF_PLACE: u64 = 300;
const STEPS_OF_STRAIGHT_PLACE: u64 = 60;
const STEPS_OF_ROOT: u64 = 50;

/// Where a point lies in a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PointInLight {
    /// How far along its way, growing from the source: t of a tube, else a length in world units.
    pub t: f64,
    /// Which way it lies on: (v, w) of a tube and of a cone; of others a place across the light.
    pub cross_coords: DVec2,
    /// World units for a unit of `across` there.
    pub width: f64,
    /// Unit vector to where its light comes from.
    pub to_light: DVec3,
    /// The same along its way, which is what visibility goes by: of a tube the tangent of the path.
    pub along_path: DVec3,
    /// Of a tube `1 - kappa r.N`, which is 0 where ways meet; else 1.
    pub path_spacing: f64,
    /// How far from the light's ends, in widths, less than 0 beyond one; infinite where it has none.
    pub distance_to_ends: f64,
}

/// The gnomonic axes about a direction of an omni light, in its own axes: what `across` is measured by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chart {
    ahead: DVec3,
    right: DVec3,
    up: DVec3,
}

impl Chart {
    /// About `ahead`, of length 1.
    pub fn about(ahead: DVec3) -> Self {
        let right = ahead.any_orthonormal_vector();
        Self { ahead, right, up: right.cross(ahead) }
    }

    /// The way in the light's axes that lies at `across`.
    pub fn direction_at(&self, across: DVec2) -> DVec3 {
        self.ahead + self.right * across.x + self.up * across.y
    }
}

/// A light as rays about the origin of scene space.
#[derive(Clone, Debug)]
pub(crate) struct SceneLight<'a> {
    pub rays: &'a LightRays,
    /// Where scene space begins, in the world.
    pub origin_in_world: DVec3,
    /// Of an omni light.
    pub chart: Chart,
    /// What finding places costs.
    pub work: &'a WorkBudget<'a>,
}

impl<'a> SceneLight<'a> {
    /// `rays` in a scene, and what an omni light is measured by: the direction to `about`.
    pub fn new(rays: &'a LightRays, origin_in_world: DVec3, about: DVec3, work: &'a WorkBudget<'a>) -> Self {
        let ahead = match rays {
            LightRays::Omni(omni) => {
                omni.rotation.transpose()
                    * (about - (omni.translation - origin_in_world)).normalize_or(DVec3::Z)
            }
            _ => DVec3::Z,
        };
        Self { rays, origin_in_world, chart: Chart::about(ahead), work }
    }

    /// The same with another light of that shape.
    pub fn with(&self, rays: &'a LightRays) -> Self {
        Self { rays, ..*self }
    }

    /// Where the source is, in scene space; of a directional light any point of its axis.
    pub fn source(&self) -> DVec3 {
        self.translation() - self.origin_in_world
    }

    /// Steps to find a place: one that is followed, or one that is looked for in every segment.
    fn locate_cost_steps(&self, is_followed: bool) -> u64 {
        match self.rays {
            LightRays::Bent(tube) if !is_followed => STEPS_OF_ROOT * tube.segments.len() as u64,
            LightRays::Bent(_) => STEPS_OF_PLACE,
            LightRays::Cone(_) | LightRays::Omni(_) | LightRays::Parallel(_) => STEPS_OF_STRAIGHT_PLACE,
        }
    }

    fn translation(&self) -> DVec3 {
        match self.rays {
            LightRays::Bent(tube) => tube.placement.translation,
            LightRays::Cone(cone) => cone.translation,
            LightRays::Omni(omni) => omni.translation,
            LightRays::Parallel(parallel) => parallel.translation,
        }
    }

    /// Where a point in scene space lies, in the light or beside it; of a tube the place that is followed from `near`, or that
    /// counts where there is none. `None` where it lies nowhere: behind a source, outside a tube that nothing is followed in.
    pub fn locate(&self, point: DVec3, near: Option<f64>) -> Option<PointInLight> {
        if !self.work.spend(self.locate_cost_steps(near.is_some())) {
            return None;
        }
        let way = point - self.source();
        match self.rays {
            LightRays::Bent(tube) => {
                let q = tube.placement.rotation.transpose() * way / tube.placement.world_per_tube;
                let root = match near {
                    None => tube.nearest_root(q)?,
                    Some(t) => track_root(tube, q, t),
                };
                Some(tube_coords(tube, &root))
            }
            LightRays::Cone(cone) => {
                let local = cone.rotation.transpose() * way;
                let depth = -local.z;
                let across = DVec2::new(-local.x, local.y) / (depth * cone.tan_outer);
                let width = depth * cone.tan_outer;
                let from_ends = cone.range.map_or(f64::INFINITY, |range| (range - depth) / width);
                (depth > 0.0).then(|| straight_coords(way, across, width, from_ends))
            }
            LightRays::Omni(omni) => {
                let (local, chart) = (omni.rotation.transpose() * way, self.chart);
                let ahead = local.dot(chart.ahead);
                let across = DVec2::new(local.dot(chart.right), local.dot(chart.up)) / ahead;
                let from_ends = omni.range.map_or(f64::INFINITY, |range| (range - way.length()) / ahead);
                (ahead > 0.0).then(|| straight_coords(way, across, ahead, from_ends))
            }
            LightRays::Parallel(parallel) => {
                let local = parallel.rotation.transpose() * way;
                let across = DVec2::new(-local.x, local.y);
                let place = straight_coords(way, across, 1.0, f64::INFINITY);
                let to_light = parallel.direction();
                Some(PointInLight { t: -local.z, to_light, along_path: to_light, ..place })
            }
        }
    }

    /// The same, with the largest component of the irradiance there on a surface square to the light, without shadows; 0 outside
    /// the light.
    pub fn locate_with_irradiance(&self, point: DVec3, near: f64) -> Option<(PointInLight, f64)> {
        if !self.work.spend(self.locate_cost_steps(true)) {
            return None;
        }
        let way = point - self.source();
        let irradiance = match self.rays {
            LightRays::Bent(tube) => {
                let q = tube.placement.rotation.transpose() * way / tube.placement.world_per_tube;
                let root = track_root(tube, q, near);
                return Some((tube_coords(tube, &root), tube.irradiance(&root).max_element()));
            }
            LightRays::Cone(cone) => cone.locate(way).map(|place| cone.irradiance(&place)),
            LightRays::Omni(omni) => omni.locate(way).map(|place| omni.irradiance(&place)),
            LightRays::Parallel(parallel) => {
                parallel.locate(point + self.origin_in_world).map(|place| parallel.irradiance(&place))
            }
        };
        Some((self.locate(point, Some(near))?, irradiance.map_or(0.0, DVec3::max_element)))
    }

    /// Of a light without a tube: where its way `across` begins, and where it is level with `point`, which lies at `place`.
    /// A sun's way begins `far` before that.
    pub fn straight_path(
        &self,
        place: &PointInLight,
        across: DVec2,
        point: DVec3,
        far: f64,
    ) -> (DVec3, DVec3) {
        let source = self.source();
        let level = |way: DVec3| (source, source + way);
        match self.rays {
            LightRays::Cone(cone) => {
                let depth = place.width / cone.tan_outer;
                level(cone.rotation * DVec3::new(-across.x * place.width, across.y * place.width, -depth))
            }
            LightRays::Omni(omni) => level(omni.rotation * self.chart.direction_at(across) * place.width),
            LightRays::Parallel(parallel) => {
                let beside = across - place.cross_coords;
                let to = point + parallel.rotation * DVec3::new(-beside.x, beside.y, 0.0);
                (to + parallel.direction() * far, to)
            }
            LightRays::Bent(_) => level(DVec3::ZERO),
        }
    }

    /// How far out in the light a place lies, squared: 1 at its edge. 0 where it has none.
    pub fn rho2(&self, place: &PointInLight) -> f64 {
        match self.rays {
            LightRays::Bent(_) | LightRays::Cone(_) => place.cross_coords.length_squared(),
            LightRays::Omni(_) => 0.0,
            LightRays::Parallel(parallel) => {
                let share = |along: f64, half: Option<f64>| half.map_or(0.0, |half| (along / half).abs());
                let out = share(place.cross_coords.x, parallel.half_size[0])
                    .max(share(place.cross_coords.y, parallel.half_size[1]));
                out * out
            }
        }
    }
}

/// The root near `t`, with the radius left aside: Newton's method on `(q - P) . P'`, each step squaring the error.
fn track_root(tube: &Tube<f64>, q: DVec3, near: f64) -> TubeRoot<f64> {
    const STEPS: usize = 12;
    // The error after such a step is its square.
    const ENOUGH: f64 = 1e-9;
    let last = tube.segments.len() - 1;
    // The extension past the last segment has no end.
    let end = if last == tube.n { f64::INFINITY } else { tube.n as f64 };
    let piece = |t: f64| {
        let index = (t as usize).min(last);
        (index, t - index as f64)
    };
    let mut t = near.clamp(0.0, end);
    for _ in 0..STEPS {
        let (segment, u) = piece(t);
        let curve = &tube.segments[segment].curve;
        let (r, d) = (curve.offset(q, u), curve.d(u));
        let slope = 2.0 * d.length_squared() - r.dot(curve.a);
        if slope <= 0.0 {
            break;
        }
        // A step of one segment at most: past the joint the curve is another.
        let step = (r.dot(d) / slope).clamp(-1.0, 1.0);
        let next = (t + step).clamp(0.0, end);
        let is_done = (next - t).abs() <= ENOUGH * (1.0 + t);
        t = next;
        if is_done {
            break;
        }
    }
    let (segment, u) = piece(t);
    let curve = &tube.segments[segment].curve;
    let u_hat = curve.u_hat(u);
    let (v_hat, w_hat) = tube.cross_section(curve, u_hat);
    let r = curve.offset(q, u);
    TubeRoot {
        segment,
        u,
        r,
        v_len: r.dot(v_hat),
        w_len: r.dot(w_hat),
        radius: curve.radius(u),
        v_hat,
        u_hat,
    }
}

/// The place of a point that light reaches by the straight `way`.
fn straight_coords(way: DVec3, across: DVec2, width: f64, from_ends: f64) -> PointInLight {
    let t = way.length();
    let to_light = -way / t;
    PointInLight {
        t,
        cross_coords: across,
        width,
        to_light,
        along_path: to_light,
        path_spacing: 1.0,
        distance_to_ends: from_ends,
    }
}

/// The place of a root.
fn tube_coords(tube: &Tube<f64>, root: &TubeRoot<f64>) -> PointInLight {
    let curve = &tube.segments[root.segment].curve;
    let turn = curve.u_hat_derivative(root.u, root.u_hat);
    let speed = 2.0 * curve.d(root.u).length();
    let scale = tube.placement.world_per_tube;
    let radius = if root.radius > 0.0 { root.radius } else { 1.0 };
    // Beyond an end r has a part along the tangent.
    let beyond = root.r.dot(root.u_hat) / radius;
    let from_end = if tube.segments.len() > tube.n {
        f64::INFINITY
    } else {
        (tube.n as f64 - root.t()) * speed / radius - beyond
    };
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

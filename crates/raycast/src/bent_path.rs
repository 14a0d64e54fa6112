//! Light paths of a BendyLight: curves of constant (v, w), cut into chords.

use glam::DVec3;
use light::{Curve, FrameMode, Tube};

use crate::{Aabb64, Bvh};

/// Maximum error of a chord as a share of its length.
///
/// The value is chosen for speed: boxes grow by the error, and a hierarchy's leaves are seldom thirty times smaller
/// than a chord. Half of it takes 1.4 times as many chords. Hits are found on the path itself, so no result depends on
/// it.
const CHORD_ERROR: f64 = 1.0 / 32.0;

/// Maximum error of a chord near the scene, as a share of the scene's size.
///
/// It is the error that `CHORD_ERROR` allows a chord of a quarter of the scene. So the part near the scene of a light a
/// million scenes long is cut about as finely as a light of the scene's own size.
const ERROR_IN_SCENE: f64 = CHORD_ERROR / 4.0;

/// Maximum number of halvings of a chord. Where the curve stops (`P' = 0`) the turn has no bound, but a piece of 2^-24
/// of a segment is as good as a point.
pub(crate) const MAX_HALVINGS: u32 = 24;

/// Curve of constant (v, w) in a light: `C(t) = P + R (v v_hat + w w_hat)` (light model, section 3).
#[derive(Clone, Copy, Debug)]
pub struct BentPath<'a> {
    pub tube: &'a Tube<f64>,
    /// Coordinate across the tube along `v_hat`, in radii.
    pub v: f64,
    /// Coordinate across the tube along `w_hat`, in radii.
    pub w: f64,
    source: DVec3,
}

impl Bvh {
    /// Makes the path of constant (v, w), both in radii, through this scene.
    pub fn bent_path<'a>(&self, tube: &'a Tube<f64>, v: f64, w: f64) -> BentPath<'a> {
        BentPath::new(tube, v, w, self.posed.origin_in_world)
    }
}

/// Piece of a path, and the straight line between its ends.
#[derive(Clone, Copy, Debug)]
pub struct Chord {
    pub segment: usize,
    /// Parameters of the two ends in that segment.
    pub u: [f64; 2],
    pub ends: [DVec3; 2],
    /// Upper bound of `|C''|` over the piece, where C is the path as a function of u, in world lengths.
    pub second_derivative_bound: f64,
}

impl Chord {
    /// Returns true if all of the path is certainly outside of `bounds`.
    fn misses(&self, bounds: &Aabb64) -> bool {
        let [from, to] = self.ends;
        // Rounding of positions is some ulps of the largest coordinate.
        let slack = 1e-14 * (from.abs().max_element() + to.abs().max_element());
        let reach = DVec3::splat(self.error() + slack);
        (from.min(to) - reach).cmpgt(bounds.max).any() || (from.max(to) + reach).cmplt(bounds.min).any()
    }

    /// Returns the bound of the distance between the line and the path at equal u: `|C''| h^2 / 8`.
    pub fn error(&self) -> f64 {
        let h = self.u[1] - self.u[0];
        // A straight piece may be infinite in u, and 0 times infinity is no bound.
        if self.second_derivative_bound == 0.0 { 0.0 } else { self.second_derivative_bound * h * h / 8.0 }
    }

    /// Returns the length of the straight line.
    pub(crate) fn length(&self) -> f64 {
        self.ends[0].distance(self.ends[1])
    }
}

impl<'a> BentPath<'a> {
    /// Makes the path of constant (v, w), both in radii, in a scene space with its origin at `origin_in_world`.
    pub fn new(tube: &'a Tube<f64>, v: f64, w: f64, origin_in_world: DVec3) -> Self {
        Self { tube, v, w, source: tube.placement.translation - origin_in_world }
    }

    /// Returns the position in scene space at parameter `u` of a segment.
    pub fn position_at(&self, segment: usize, u: f64) -> DVec3 {
        let s = &self.tube.segments[segment].curve;
        let (v_hat, w_hat) = self.tube.cross_section(s, s.u_hat(u));
        let in_tube = s.position(u) + (v_hat * self.v + w_hat * self.w) * s.radius(u);
        let placement = &self.tube.placement;
        self.source + placement.rotation * (in_tube * placement.world_per_tube)
    }

    /// Calls `visit` with chords from the source to `t_end`, in order, until it returns `true`. Chords that miss
    /// `bounds` are left out. The error of each is at most 1/32 of its length, and 1/128 of the size of `bounds`.
    pub fn for_each_chord(&self, t_end: f64, bounds: &Aabb64, mut visit: impl FnMut(&Chord) -> bool) {
        for segment in 0..self.tube.segments.len() {
            let start = segment as f64;
            // The extension past the last segment has no end of its own.
            let u_end = if segment == self.tube.n { t_end - start } else { (t_end - start).min(1.0) };
            if u_end <= 0.0 {
                return;
            }
            let ends = [self.position_at(segment, 0.0), self.position_at(segment, u_end)];
            if self.subdivide(segment, [0.0, u_end], ends, 0, bounds, &mut visit) {
                return;
            }
        }
    }

    fn subdivide(
        &self,
        segment: usize,
        u: [f64; 2],
        ends: [DVec3; 2],
        halvings: u32,
        bounds: &Aabb64,
        visit: &mut impl FnMut(&Chord) -> bool,
    ) -> bool {
        let chord = Chord { segment, u, ends, second_derivative_bound: self.second_derivative_bound(segment, u) };
        if chord.misses(bounds) {
            return false;
        }
        let error = chord.error();
        let is_fine = error <= CHORD_ERROR * chord.length() && error <= ERROR_IN_SCENE * bounds.size();
        if is_fine || halvings == MAX_HALVINGS {
            return visit(&chord);
        }
        let middle = f64::midpoint(u[0], u[1]);
        let at_middle = self.position_at(segment, middle);
        self.subdivide(segment, [u[0], middle], [ends[0], at_middle], halvings + 1, bounds, visit)
            || self.subdivide(segment, [middle, u[1]], [at_middle, ends[1]], halvings + 1, bounds, visit)
    }

    /// Makes the chord between two parameters of a segment.
    pub(crate) fn chord(&self, segment: usize, u: [f64; 2]) -> Chord {
        Chord {
            segment,
            u,
            ends: u.map(|u| self.position_at(segment, u)),
            second_derivative_bound: self.second_derivative_bound(segment, u),
        }
    }

    /// Returns the bound of `|C''|` over a piece, in u, in world lengths.
    ///
    /// With `e = v v_hat + w w_hat`, `rho = |e|`, `C'' = P'' + R'' e + 2 R' e' + R e''`. The tangent turns by `omega =
    /// |u_hat'| = |d0 x a| / |d|^2`, whose own derivative is at most `2 omega |a| / |d|`. A frame that twists by `tau`
    /// has `e' = -(e.u_hat') u_hat + tau (u_hat x e)`.
    fn second_derivative_bound(&self, segment: usize, [start, end]: [f64; 2]) -> f64 {
        let s = &self.tube.segments[segment].curve;
        let rho = libm::hypot(self.v, self.w);
        let h = end - start;
        // Between its ends a quadratic is at most |R''| h^2 / 8 above the larger of them.
        let radius = s.radius(start).max(s.radius(end)) + if s.ar == 0.0 { 0.0 } else { s.ar.abs() * h * h / 4.0 };
        let widening = s.radius_derivative(start).abs().max(s.radius_derivative(end).abs());
        let turn = Turn::of(s, [start, end]);
        let twist = match self.tube.frame {
            FrameMode::RotationMinimizing => Twist::default(),
            FrameMode::Up => Twist::of(self.tube.up, s, [start, end], turn),
        };
        let first = rho * (turn.omega + twist.tau);
        let second = first * turn.omega
            + rho * (turn.change + 2.0 * turn.omega * turn.omega)
            + rho * twist.change
            + twist.tau * (turn.omega * rho + first);
        let bend = 2.0 * s.a.length() + 2.0 * s.ar.abs() * rho + 2.0 * widening * first + radius * second;
        bend * self.tube.placement.world_per_tube
    }
}

/// Upper bounds for the turn of the tangent over a piece, in u.
#[derive(Clone, Copy, Default)]
struct Turn {
    /// Bound of `|u_hat'|`.
    omega: f64,
    /// Bound of the derivative of `|u_hat'|`.
    change: f64,
}

impl Turn {
    fn of(s: &Curve<f64>, [start, end]: [f64; 2]) -> Self {
        let across = s.d0.cross(s.a).length();
        if across == 0.0 {
            return Self::default();
        }
        // |d| is least where d . a = 0.
        let nearest = (-s.d0.dot(s.a) / s.a.length_squared()).clamp(start, end);
        let slowest = s.d(nearest).length();
        let omega = across / (slowest * slowest);
        Self { omega, change: 2.0 * omega * s.a.length() / slowest }
    }
}

/// Bounds of the twist of the "up" frame about the tangent over a piece, in u.
#[derive(Default)]
struct Twist {
    tau: f64,
    change: f64,
}

impl Twist {
    /// Bounds `tau = c (u_hat' . v_hat) / s`, `c = up . u_hat`, `s = |up - c u_hat|`: `|c'| <= s omega` and
    /// `|s'| <= omega`.
    fn of(up: DVec3, curve: &Curve<f64>, [start, end]: [f64; 2], turn: Turn) -> Self {
        let u_hat = curve.u_hat(f64::midpoint(start, end));
        let sine = (up - u_hat * up.dot(u_hat)).length() - turn.omega * (end - start) / 2.0;
        // The frame flips where the tangent meets `up`, and nothing bounds that.
        let sine = sine.max(1e-9);
        let tau = turn.omega / sine;
        let change = turn.omega * turn.omega * (1.0 + 1.0 / (sine * sine)) + (turn.change + tau * turn.omega) / sine;
        Self { tau, change }
    }
}

#[cfg(test)]
mod tests {
    use light::Light;
    use light::parameters::TRANSLATION;
    use scene::{Material, Mesh, Node, Primitive, Scene};

    use super::*;
    use crate::hierarchy::ThickLine;

    /// Returns a wavy field of 2 n^2 triangles, 10 units wide.
    fn field(n: u32) -> Scene {
        let corner = |k: u32| {
            let (x, z) = ((k % (n + 1)) as f32 / n as f32, (k / (n + 1)) as f32 / n as f32);
            glam::Vec3::new(10.0 * x - 5.0, libm::sinf(7.0 * x * z), 10.0 * z - 5.0)
        };
        let positions: Vec<_> = (0..(n + 1) * (n + 1)).map(corner).collect();
        let quad = |k: u32| {
            let a = k / n * (n + 1) + k % n;
            [a, a + n + 1, a + 1, a + 1, a + n + 1, a + n + 2]
        };
        let primitive = Primitive {
            normals: vec![glam::Vec3::Y; positions.len()],
            indices: (0..n * n).flat_map(quad).collect(),
            positions,
            ..Primitive::default()
        };
        let node =
            Node { name: "field".into(), parent: None, parent_from_local: glam::DAffine3::IDENTITY, mesh: Some(0) };
        Scene {
            nodes: vec![node],
            meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
            materials: vec![Material::default()],
            ..Scene::default()
        }
    }

    /// Returns a light `size` units long that bends by a right angle at the centre of the field and is 3 units wide
    /// there.
    fn light_of(size: f64) -> Tube<f64> {
        let direction = DVec3::new(0.6, -0.64, 0.48);
        let aside = direction.any_orthonormal_vector();
        let points = [DVec3::ZERO, direction * 0.5, (direction + aside) * 0.5].map(|point| point * size);
        let light = Light::bendy(points.into(), vec![3.0; 3]);
        let middle = Tube::<f64>::new(&light).expect("a light").segments[0].curve.position(0.5);
        Tube::new(&light.with(TRANSLATION, -middle)).expect("a light")
    }

    /// Returns the mean number of triangles whose boxes a path's chords touch, over paths all over the light.
    fn triangles_tested_per_path(bvh: &Bvh, tube: &Tube<f64>, bounds: &Aabb64) -> f64 {
        let mut asked = 0;
        for k in 0..64 {
            let (v, w) = (f64::from(k % 8) / 8.0 - 0.4, f64::from(k / 8) / 8.0 - 0.4);
            bvh.bent_path(tube, v, w).for_each_chord(1.0, bounds, |chord| {
                let [from, to] = chord.ends;
                bvh.hierarchy.visit_along_line(
                    ThickLine { from, to, radius: chord.error() },
                    |_| true,
                    |_| {
                        asked += 1;
                        1.0
                    },
                );
                false
            });
        }
        f64::from(asked) / 64.0
    }

    /// The cost of a light depends on its part in the scene, not on its length.
    #[test]
    fn a_long_light_asks_few_triangles() {
        let bvh = Bvh::new(scene::pose(field(64), 0.0));
        let bounds = bvh.hierarchy.bounds().expect("a box");
        let ordinary = triangles_tested_per_path(&bvh, &light_of(30.0), &bounds);
        for size in [1e3, 1e4, 1e6, 1e9] {
            let tube = light_of(size);
            let asked = triangles_tested_per_path(&bvh, &tube, &bounds);
            // Deliberate fault that the check must detect: chords that are cut by their own length alone.
            let uncut = triangles_tested_per_path(&bvh, &tube, &Aabb64::INFINITE);
            println!(
                "{size:e} units: {asked:.0} triangles a path, cut by length alone {uncut:.0}; 30 units: {ordinary:.0}"
            );
            // Halving reduces the error to a quarter, so one light may have chords four times as thick as another.
            assert!(asked <= 4.0 * ordinary, "{size:e}: {asked} triangles a path");
            assert!(size < 1e4 || uncut > 8.0 * asked, "{size:e}: {uncut}");
        }
    }

    /// No hit depends on the cuts of a path.
    #[test]
    fn hits_do_not_depend_on_the_cut() {
        let bvh = Bvh::new(scene::pose(field(16), 0.0));
        let mut hits = 0;
        for size in [30.0, 1e3, 1e6] {
            let tube = light_of(size);
            for k in 0..64 {
                let path = bvh.bent_path(&tube, f64::from(k % 8) / 4.5 - 0.7, f64::from(k / 8) / 4.5 - 0.7);
                let first = |bounds: &Aabb64| {
                    bvh.first_bent_hit_in_bounds(&path, 1.0, bounds, &|_| true, &|_: &_| true, false)
                        .map(|hit| (hit.triangle, hit.position))
                };
                let (cut, whole) = (first(&bvh.hierarchy.bounds().expect("a box")), first(&Aabb64::INFINITE));
                hits += usize::from(cut.is_some());
                match (cut, whole) {
                    (None, None) => {}
                    // Positions round by some ulps of the light's size, and a grazing path amplifies that along itself.
                    (Some((a, at)), Some((b, there))) if a == b && at.distance(there) < 1e-9 + 1e-13 * size => {}
                    _ => panic!("{size:e} {k}: {cut:?} {whole:?}"),
                }
            }
        }
        assert!(hits > 50, "{hits}");
    }
}

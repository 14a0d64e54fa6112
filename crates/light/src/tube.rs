//! The evaluated light: where a point lies in it and where its light comes from.

use glam::DVec3;

use crate::build::{self, Placement};
use crate::segment::Segment;
use crate::solve::increasing_roots;
use crate::{BendyLight, Decay, Direction, EndMode, Frame, LightError, Real, arc};

/// A checked BendyLight, prepared for evaluation in `F` (light model, sections 1 to 6).
///
/// Everything is prepared in f64 and, for `f32`, rounded once. Geometry is in tube space, see [`Placement`].
///
/// Accuracy: for tubes with `R kappa <= 0.9` and `|P'| >= 0.1 L`, `L = |d0| + |d1|`, the parameter of a point
/// at offset `r` is within `16 eps cond`, `cond = (|r| + L) / (|P'| (1 - kappa r.N))`, `eps` 2^-52 or 2^-24;
/// times `1 + |world offset| / size` for world positions.
#[derive(Clone, Debug)]
pub struct Tube<F: Real> {
    /// The segments; with [`EndMode::Extend`] one more, whose parameter has no end.
    pub segments: Vec<Segment<F>>,
    /// Number of quadratic segments `n`: `t` runs from 0 to `n`, or on where the light is extended.
    pub n: usize,
    /// Tube space in the world.
    pub placement: Placement,
    /// Orientation of the cross-section.
    pub frame: Frame,
    /// Unit vector that orients it where `frame` is [`Frame::Up`].
    pub up: F::Vec3,
    /// Direction of arrival.
    pub direction: Direction,
    /// Fall-off with distance.
    pub decay: Decay,
    /// Falls from 1 to 0 across the tube.
    pub profile: Profile<F>,
    /// Square of the distance within which light falls off no further, in tube units: a point on the source itself
    /// would be infinitely bright. A millionth of the light's length.
    pub least_distance2: F,
}

/// One way to reach a point from the curve, inside the tube. Lengths in tube space.
#[derive(Clone, Copy, Debug)]
pub struct Root<F: Real> {
    /// Index of the segment; `n` on the extension.
    pub segment: usize,
    /// Parameter in the segment.
    pub u: F,
    /// `q - P(u)`.
    pub r: F::Vec3,
    /// `r . v_hat`; never divided by the radius here, which may be zero.
    pub v_len: F,
    /// `r . w_hat`.
    pub w_len: F,
    /// Radius of the tube at `u`.
    pub radius: F,
    /// `v_hat` at `u`.
    pub v_hat: F::Vec3,
    /// `u_hat` at `u`.
    pub u_hat: F::Vec3,
}

/// Where a point lies in a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubePoint {
    /// Index of the quadratic segment; `n` past the end of an extended light.
    pub segment: usize,
    /// Parameter in the segment.
    pub u: f64,
    /// Global parameter `segment + u`.
    pub t: f64,
    /// Cross-section coordinate along `v_hat`, in radii.
    pub v: f64,
    /// Cross-section coordinate along `w_hat`, in radii.
    pub w: f64,
    /// Radius of the tube there, in world units.
    pub radius: f64,
    /// Unit vector in world space from the surface to where its light comes from.
    pub direction: DVec3,
}

/// The answer for one world position.
#[derive(Clone, Debug, PartialEq)]
pub struct Location {
    /// The point's place, or `None` outside the light. Where distant parts of a tube overlap, the one with
    /// the smallest `|r| / R`.
    pub point: Option<TubePoint>,
    /// Every in-tube `t`, ascending; one at a joint counted once.
    pub roots: Vec<f64>,
}

/// The smooth profile over `rho = |r| / R` (light model, section 6): 1 inside, then an S-curve to 0 at the
/// tube's edge.
///
/// `rho` stands for the angle `theta = atan(rho tan coneAngle)` of a spotlight; the curve is `s^2 (3 - 2 s)`,
/// `s = (cos theta - cos outer) / (cos inner - cos outer)`, `inner = outer (1 - coneSoftness)`. Cosines, as
/// Real-Time Rendering's eq. 7.18 has them, need no inverse trigonometry, which GPUs do badly.
#[derive(Clone, Copy, Debug)]
pub struct Profile<F> {
    /// `tan^2 coneAngle`.
    pub tan2_outer: F,
    /// `cos coneAngle`.
    pub cos_outer: F,
    /// `1 / (cos inner - cos outer)`; 0 where they are equal, which makes the profile a step.
    pub inv_cos_range: F,
}

impl Profile<f64> {
    /// The profile of a nominal half angle in degrees and its softness.
    pub fn new(cone_angle: f64, cone_softness: f64) -> Self {
        let outer = cone_angle.to_radians();
        let (cos_outer, cos_inner) = (libm::cos(outer), libm::cos(outer * (1.0 - cone_softness)));
        let tan = libm::tan(outer);
        let range = cos_inner - cos_outer;
        Self { tan2_outer: tan * tan, cos_outer, inv_cos_range: if range > 1e-9 { 1.0 / range } else { 0.0 } }
    }
}

impl<F: Real> Profile<F> {
    /// Value at `rho`, inside the tube.
    pub fn at(&self, rho: F) -> F {
        let (zero, one) = (F::of(0.0), F::of(1.0));
        if self.inv_cos_range == zero {
            return one;
        }
        let cos = one / (one + rho * rho * self.tan2_outer).sqrt();
        let s = ((cos - self.cos_outer) * self.inv_cos_range).within(zero, one);
        s * s * (F::of(3.0) - F::of(2.0) * s)
    }
}

impl Tube<f64> {
    /// Checks a light and prepares it; refuses folds, degenerate segments and numbers outside their domain.
    pub fn new(light: &BendyLight) -> Result<Self, LightError> {
        let (segments, placement) = build::segments(light)?;
        Ok(Self {
            segments,
            n: light.points.len() - 2,
            placement,
            frame: light.frame,
            up: build::unit_up(light),
            direction: light.direction,
            decay: light.decay,
            profile: Profile::new(light.cone_angle, light.cone_softness),
            least_distance2: 1e-12,
        })
    }

    /// The largest `R kappa` of each segment, below 1.
    pub fn r_kappa_max(&self) -> Vec<f64> {
        self.segments[..self.n].iter().map(crate::validity::r_kappa_max).collect()
    }
}

impl From<&Tube<f64>> for Tube<f32> {
    fn from(tube: &Tube<f64>) -> Self {
        let Profile { tan2_outer, cos_outer, inv_cos_range } = tube.profile;
        Self {
            segments: tube.segments.iter().map(Segment::to_f32).collect(),
            n: tube.n,
            placement: tube.placement,
            frame: tube.frame,
            up: tube.up.as_vec3(),
            direction: tube.direction,
            decay: tube.decay,
            profile: Profile {
                tan2_outer: tan2_outer as f32,
                cos_outer: cos_outer as f32,
                inv_cos_range: inv_cos_range as f32,
            },
            least_distance2: tube.least_distance2 as f32,
        }
    }
}

impl<F: Real> Tube<F> {
    /// Whether the light goes on past its last control point.
    pub fn end_mode(&self) -> EndMode {
        if self.segments.len() > self.n { EndMode::Extend } else { EndMode::Cut }
    }

    /// Calls `found` with every in-tube root of the tube-space point `q`, in ascending t; one at a joint
    /// comes once.
    pub fn for_each_root(&self, q: F::Vec3, mut found: impl FnMut(Root<F>)) {
        let (zero, one) = (F::of(0.0), F::of(1.0));
        let mut last: Option<(usize, F)> = None;
        let mut report = |segment: usize, u: F| {
            let same = |(i, v): (usize, F)| F::of((segment - i) as f64) + (u - v) < F::JOINT_MERGE;
            if !last.is_some_and(same)
                && let Some(root) = self.root_inside(segment, q, u)
            {
                last = Some((segment, u));
                found(root);
            }
        };
        let first = &self.segments[0];
        let mut f0 = -F::dot(q - first.b0, first.d0);
        for (i, segment) in self.segments.iter().enumerate() {
            if i == self.n {
                let u = -f0 / (F::of(2.0) * F::dot(segment.d0, segment.d0));
                if u > zero {
                    report(i, u);
                }
                break;
            }
            // One value a joint, shared by the segments that meet there.
            let f1 = -F::dot(q - segment.b2, segment.d1);
            if segment.bounds.contains(q) {
                for u in increasing_roots(segment, q, f0, f1).into_iter().flatten() {
                    report(i, u.within(zero, one));
                }
            }
            f0 = f1;
        }
    }

    /// The root at `u` if it lies in the tube: `|r| <= R`.
    fn root_inside(&self, segment: usize, q: F::Vec3, u: F) -> Option<Root<F>> {
        let s = &self.segments[segment];
        let (r, radius) = (s.offset(q, u), s.radius(u));
        if !(radius >= F::of(0.0) && F::dot(r, r) <= radius * radius) {
            return None;
        }
        let u_hat = s.u_hat(u);
        let (v_hat, w_hat) = self.cross_section(s, u_hat);
        Some(Root { segment, u, r, v_len: F::dot(r, v_hat), w_len: F::dot(r, w_hat), radius, v_hat, u_hat })
    }

    /// `(v_hat, w_hat)` across the unit tangent, in the light's frame mode.
    pub fn cross_section(&self, segment: &Segment<F>, u_hat: F::Vec3) -> (F::Vec3, F::Vec3) {
        if self.frame == Frame::RotationMinimizing {
            return segment.rotation_minimizing(u_hat);
        }
        let w_hat = build::perpendicular_up::<F>(self.up, u_hat);
        (F::cross(w_hat, u_hat), w_hat)
    }

    /// The root that counts: the one with the smallest `|r| / R` (light model, section 5).
    pub fn nearest_root(&self, q: F::Vec3) -> Option<Root<F>> {
        let mut best: Option<Root<F>> = None;
        self.for_each_root(q, |root| {
            if best.is_none_or(|b| nearer(&root, &b)) {
                best = Some(root);
            }
        });
        best
    }

    /// Unit direction in tube space from the surface to where its light comes from, in the light's mode (light
    /// model, section 3, times R).
    pub fn direction_at(&self, root: &Root<F>) -> F::Vec3 {
        self.direction_by(self.direction, root)
    }

    /// The same by the tangent of the path, whatever the light's mode: the way that visibility follows.
    pub fn path_direction_at(&self, root: &Root<F>) -> F::Vec3 {
        self.direction_by(Direction::Path, root)
    }

    fn direction_by(&self, direction: Direction, root: &Root<F>) -> F::Vec3 {
        let s = &self.segments[root.segment];
        let (u_hat, r, radius) = (root.u_hat, root.r, root.radius);
        let spread = r * s.radius_derivative(root.u);
        let tangent = match direction {
            Direction::Tube => s.d(root.u) * (F::of(2.0) * radius) + spread,
            Direction::Path => {
                let turn = s.u_hat_derivative(root.u, u_hat);
                let speed = F::of(2.0) * F::dot(s.d(root.u), s.d(root.u)).sqrt();
                let along = u_hat * ((speed - F::dot(r, turn)) * radius) + spread;
                along + F::cross(u_hat, r) * (self.twist(root, turn) * radius)
            }
        };
        let length = F::dot(tangent, tangent).sqrt();
        if length < F::DIRECTION_FLOOR { -u_hat } else { tangent * (F::of(-1.0) / length) }
    }

    /// `tau`, the frame's rotation about the tangent per unit of u; zero for the rotation-minimising frame.
    fn twist(&self, root: &Root<F>, u_hat_derivative: F::Vec3) -> F {
        if self.frame == Frame::RotationMinimizing {
            return F::of(0.0);
        }
        let along = F::dot(self.up, root.u_hat);
        let perp = self.up - root.u_hat * along;
        let length = F::dot(perp, perp).sqrt().most(F::of(1e-6));
        along * F::dot(u_hat_derivative, root.v_hat) / length
    }

    /// Irradiance on a surface square to the light, linear RGB: colour, intensity, profile and decay (light
    /// model, section 6), without visibility.
    pub fn irradiance(&self, root: &Root<F>) -> F::Vec3 {
        let (zero, one) = (F::of(0.0), F::of(1.0));
        let s = &self.segments[root.segment];
        let (u, w) = (root.u, one - root.u);
        let basis = [w * w, F::of(2.0) * w * u, u * u];
        let color = s.color[0] * basis[0] + s.color[1] * basis[1] + s.color[2] * basis[2];
        let intensity = s.intensity[0] * basis[0] + s.intensity[1] * basis[1] + s.intensity[2] * basis[2];
        let rho = if root.radius > zero { F::dot(root.r, root.r).sqrt() / root.radius } else { zero };
        F::not_negative(color) * (intensity.most(zero) * self.profile.at(rho) * self.decay_at(root))
    }

    /// `decay(s)`, `s = sqrt(s_c^2 + |r|^2)` in world units with `s_c` the arc length to the root.
    fn decay_at(&self, root: &Root<F>) -> F {
        if self.decay == Decay::None {
            return F::of(1.0);
        }
        let s = &self.segments[root.segment];
        let along = s.arc_start + arc::length(s, root.u);
        let s2 = along * along + F::dot(root.r, root.r);
        let world = F::of(self.placement.world_per_tube);
        let s2 = s2.most(self.least_distance2) * (world * world);
        F::of(1.0) / if self.decay == Decay::Linear { s2.sqrt() } else { s2 }
    }

    /// Where a world position lies in the light.
    pub fn locate(&self, point_in_world: DVec3) -> Location {
        let q = F::vec(self.placement.tube_from_world(point_in_world));
        let mut roots = Vec::new();
        let mut best: Option<Root<F>> = None;
        self.for_each_root(q, |root| {
            roots.push(root.segment as f64 + root.u.f64());
            if best.is_none_or(|b| nearer(&root, &b)) {
                best = Some(root);
            }
        });
        Location { point: best.map(|root| self.describe(&root)), roots }
    }

    /// A root in the terms that people and files use.
    pub fn describe(&self, root: &Root<F>) -> TubePoint {
        let over_radius = |x: F| if root.radius > F::of(0.0) { (x / root.radius).f64() } else { 0.0 };
        TubePoint {
            segment: root.segment,
            u: root.u.f64(),
            t: root.segment as f64 + root.u.f64(),
            v: over_radius(root.v_len),
            w: over_radius(root.w_len),
            radius: root.radius.f64() * self.placement.world_per_tube,
            direction: self.placement.rotation * F::vec_f64(self.direction_at(root)),
        }
    }
}

/// Whether `a` has the smaller `|r| / R`; asked without dividing, since R may be zero (then r is zero too).
fn nearer<F: Real>(a: &Root<F>, b: &Root<F>) -> bool {
    let rho2 = |x: &Root<F>, y: &Root<F>| F::dot(x.r, x.r) * y.radius * y.radius;
    rho2(a, b) < rho2(b, a)
}

//! The evaluated light: where a point lies in it and where its light comes from.

use glam::DVec3;

use crate::arc::arc_length;
use crate::build::{self, Placement};
use crate::curve::Curve;
use crate::frame::perpendicular_up;
use crate::lanes::{Lanes, Mask, choose_vec};
use crate::parameters::{DIRECTION, END_MODE, FRAME};
use crate::profile::{LightProfile, irradiance};
use crate::solve::{Roots, increasing_roots};
use crate::{ControlPoint, DirectionMode, EndMode, FrameMode, Light, LightCoords, LightError, Real, Segment};

/// A checked BendyLight, prepared for evaluation in `F` (light model, sections 1 to 6).
///
/// Everything is prepared in f64 and, for `f32`, rounded once. Geometry is in tube space, see [`Placement`].
///
/// Accuracy: for tubes with `R kappa <= 0.9` and `|P'| >= 0.1 L`, `L = |d0| + |d1|`, the parameter of a point
/// at offset `r` is within `16 eps cond`, `cond = (|r| + L) / (|P'| (1 - kappa r.N))`, `eps` 2^-52 or 2^-24;
/// times `1 + |world offset| / size` for world positions.
#[derive(Clone, Debug)]
pub struct Tube<F: Lanes> {
    /// The segments; with [`EndMode::Extend`] one more, whose parameter has no end.
    pub segments: Vec<Segment<F>>,
    /// Number of quadratic segments `n`: `t` runs from 0 to `n`, or on where the light is extended.
    pub n: usize,
    /// Tube space in the world.
    pub placement: Placement,
    /// Orientation of the cross-section.
    pub frame: FrameMode,
    /// Unit vector that orients it where `frame` is [`FrameMode::Up`].
    pub up: F::Vec3,
    /// Direction of arrival.
    pub direction: DirectionMode,
    /// What follows from the place. Its least distance is a millionth of the light's length.
    pub light_profile: LightProfile,
}

/// One way to reach a point from the curve, inside the tube. Lengths in tube space.
#[derive(Clone, Copy, Debug)]
pub struct TubeRoot<F: Lanes> {
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

impl<F: Real> TubeRoot<F> {
    /// Global parameter `segment + u`.
    pub fn t(&self) -> f64 {
        self.segment as f64 + self.u.f64()
    }
}

/// A root that lies in the tube, before its frame is known: what a search for the nearest compares.
#[derive(Clone, Copy, Debug)]
pub struct RootInTube<F: Lanes> {
    /// Index of the segment; `n` on the extension.
    pub segment: usize,
    /// Parameter in the segment.
    pub u: F,
    /// `q - P(u)`.
    pub r: F::Vec3,
    /// `|r|^2`.
    pub r2: F,
    /// Radius of the tube at `u`.
    pub radius: F,
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
pub struct TubeLocation {
    /// The point's place, or `None` outside the light. Where distant parts of a tube overlap, the one with
    /// the smallest `|r| / R`.
    pub point: Option<TubePoint>,
    /// Every in-tube `t`, ascending; one at a joint counted once.
    pub roots: Vec<f64>,
}

impl Tube<f64> {
    /// Checks a light and prepares it; refuses folds, degenerate segments and numbers outside their domain.
    pub fn new(light: &Light) -> Result<Self, LightError> {
        let (segments, placement) = build::segments(light)?;
        Ok(Self {
            segments,
            n: light.points().len() - 2,
            placement,
            frame: light.get(FRAME),
            up: build::unit_up(light),
            direction: light.get(DIRECTION),
            light_profile: LightProfile::of(light, least_distance(&placement)),
        })
    }

    /// What [`Tube::new`] makes of `light`, which this was made of, with other control points: the same bits, without looking at
    /// all its other values again.
    pub fn with_points(&self, light: &Light, points: &[ControlPoint]) -> Result<Self, LightError> {
        let (segments, placement) =
            build::segments_of_points(points, light.transform(), self.up, light.get(END_MODE))?;
        let light_profile = self.light_profile.clone().with_min_distance(light, least_distance(&placement));
        Ok(Self { segments, n: points.len() - 2, placement, light_profile, ..*self })
    }

    /// The largest `R kappa` of each segment, below 1.
    pub fn r_kappa_max(&self) -> Vec<f64> {
        self.segments[..self.n].iter().map(|segment| crate::validity::r_kappa_max(&segment.curve)).collect()
    }

    /// The place of a root.
    pub fn place_at(&self, root: &TubeRoot<f64>) -> LightCoords {
        let TubePoint { t, v, w, direction, .. } = self.tube_point(root);
        LightCoords { t, v, w, s: self.path_length(root), direction }
    }

    /// Irradiance at a root on a surface square to the light, linear RGB, without visibility.
    pub fn irradiance(&self, root: &TubeRoot<f64>) -> DVec3 {
        irradiance(&self.light_profile, self.segments[root.segment].emission(root.u), &self.place_at(root))
    }
}

impl From<&Tube<f64>> for Tube<f32> {
    fn from(tube: &Tube<f64>) -> Self {
        Self {
            segments: tube.segments.iter().map(Segment::to_f32).collect(),
            n: tube.n,
            placement: tube.placement,
            frame: tube.frame,
            up: tube.up.as_vec3(),
            direction: tube.direction,
            light_profile: tube.light_profile.clone(),
        }
    }
}

impl<F: Lanes> Tube<F> {
    /// Whether the light goes on past its last control point.
    pub fn end_mode(&self) -> EndMode {
        if self.segments.len() > self.n { EndMode::Extend } else { EndMode::Cut }
    }

    /// `f` at the start of the first segment.
    #[inline(always)]
    pub fn first_joint(&self, q: F::Vec3) -> F {
        let first = &self.segments[0].curve;
        -F::dot(q - first.b0, first.d0)
    }

    /// `f` at the end of segment `i`: one value a joint, shared by the segments that meet there.
    #[inline(always)]
    pub fn end_joint(&self, i: usize, q: F::Vec3) -> F {
        let curve = &self.segments[i].curve;
        -F::dot(q - curve.b2, curve.d1)
    }

    /// The parameters to test on segment `i`, whose ends have the values `f0` and `f1`; the extension, `i = n`, has
    /// one without end.
    #[inline(always)]
    pub fn candidates(&self, i: usize, q: F::Vec3, f0: F, f1: F) -> Roots<F> {
        let curve = &self.segments[i].curve;
        if i == self.n {
            let left = -f0 / (F::of(2.0) * F::dot(curve.d0, curve.d0));
            return Roots { left, has_left: left.gt(F::of(0.0)), ..Roots::none() };
        }
        let is_near = curve.bounds.contains(q);
        if !is_near.any() {
            return Roots::none();
        }
        let roots = increasing_roots(curve, q, f0, f1);
        Roots { has_left: roots.has_left & is_near, has_right: roots.has_right & is_near, ..roots }
    }

    /// The root at `u` of segment `i`, and whether it lies in the tube: `|r| <= R`.
    #[inline(always)]
    pub fn inside_at(&self, i: usize, q: F::Vec3, u: F) -> (RootInTube<F>, F::Mask) {
        let curve = &self.segments[i].curve;
        let (r, radius) = (curve.offset(q, u), curve.radius(u));
        let r2 = F::dot(r, r);
        let is_inside = radius.ge(F::of(0.0)) & r2.le(radius * radius);
        (RootInTube { segment: i, u, r, r2, radius }, is_inside)
    }

    /// All that is known at a root.
    #[inline(always)]
    pub fn root_at(&self, inside: &RootInTube<F>) -> TubeRoot<F> {
        let RootInTube { segment, u, r, radius, .. } = *inside;
        let curve = &self.segments[segment].curve;
        let u_hat = curve.u_hat(u);
        let (v_hat, w_hat) = self.cross_section(curve, u_hat);
        TubeRoot { segment, u, r, v_len: F::dot(r, v_hat), w_len: F::dot(r, w_hat), radius, v_hat, u_hat }
    }

    /// `(v_hat, w_hat)` across the unit tangent, in the light's frame mode.
    #[inline(always)]
    pub fn cross_section(&self, curve: &Curve<F>, u_hat: F::Vec3) -> (F::Vec3, F::Vec3) {
        if self.frame == FrameMode::RotationMinimizing {
            return curve.rotation_minimizing(u_hat);
        }
        let w_hat = perpendicular_up::<F>(self.up, u_hat);
        (F::cross(w_hat, u_hat), w_hat)
    }

    /// Unit direction in tube space from the surface to where its light comes from, in the light's mode (light
    /// model, section 3, times R).
    #[inline(always)]
    pub fn direction_at(&self, root: &TubeRoot<F>) -> F::Vec3 {
        self.direction_by(self.direction, root)
    }

    /// The same by the tangent of the path, whatever the light's mode: the way that visibility follows.
    #[inline(always)]
    pub fn path_direction_at(&self, root: &TubeRoot<F>) -> F::Vec3 {
        self.direction_by(DirectionMode::Path, root)
    }

    #[inline(always)]
    fn direction_by(&self, direction: DirectionMode, root: &TubeRoot<F>) -> F::Vec3 {
        let curve = &self.segments[root.segment].curve;
        let (u_hat, r, radius) = (root.u_hat, root.r, root.radius);
        let spread = r * curve.radius_derivative(root.u);
        let tangent = match direction {
            DirectionMode::Tube => curve.d(root.u) * (F::of(2.0) * radius) + spread,
            DirectionMode::Path => {
                let turn = curve.u_hat_derivative(root.u, u_hat);
                let speed = F::of(2.0) * F::length(curve.d(root.u));
                let along = u_hat * ((speed - F::dot(r, turn)) * radius) + spread;
                along + F::cross(u_hat, r) * (self.twist(root, turn) * radius)
            }
        };
        let length = F::length(tangent);
        choose_vec!(F, length.lt(F::DIRECTION_FLOOR), -u_hat, tangent * (F::of(-1.0) / length))
    }

    /// `tau`, the frame's rotation about the tangent per unit of u; zero for the rotation-minimising frame.
    #[inline(always)]
    pub fn twist(&self, root: &TubeRoot<F>, u_hat_derivative: F::Vec3) -> F {
        if self.frame == FrameMode::RotationMinimizing {
            return F::of(0.0);
        }
        let along = F::dot(self.up, root.u_hat);
        let length = F::length(self.up - root.u_hat * along).most(F::of(1e-6));
        along * F::dot(u_hat_derivative, root.v_hat) / length
    }

    /// Length of the way to a root, `sqrt(s_c^2 + |r|^2)` in world units with `s_c` the arc length along the curve.
    #[inline(always)]
    pub fn path_length(&self, root: &TubeRoot<F>) -> F {
        let segment = &self.segments[root.segment];
        let along = segment.arc_start + arc_length(&segment.curve, root.u);
        (along * along + F::dot(root.r, root.r)).sqrt() * F::of(self.placement.world_per_tube)
    }
}

impl<F: Real> Tube<F> {
    /// Calls `found` with every in-tube root of the tube-space point `q`, in ascending t; one at a joint
    /// comes once.
    pub fn for_each_root(&self, q: F::Vec3, mut found: impl FnMut(TubeRoot<F>)) {
        self.for_each_root_in_tube(q, |inside| found(self.root_at(&inside)));
    }

    fn for_each_root_in_tube(&self, q: F::Vec3, mut found: impl FnMut(RootInTube<F>)) {
        let mut last: Option<(usize, F)> = None;
        let mut report = |i: usize, u: F| {
            let same = |(j, v): (usize, F)| F::of((i - j) as f64) + (u - v) < F::JOINT_MERGE;
            let (inside, is_inside) = self.inside_at(i, q, u);
            if is_inside && !last.is_some_and(same) {
                last = Some((i, u));
                found(inside);
            }
        };
        let mut f0 = self.first_joint(q);
        for i in 0..self.segments.len() {
            let f1 = self.end_joint(i, q);
            self.candidates(i, q, f0, f1).found().for_each(|u| report(i, u));
            f0 = f1;
        }
    }

    /// The root that counts: the one with the smallest `|r| / R` (light model, section 5).
    pub fn nearest_root(&self, q: F::Vec3) -> Option<TubeRoot<F>> {
        self.nearest_inside(q).map(|inside| self.root_at(&inside))
    }

    fn nearest_inside(&self, q: F::Vec3) -> Option<RootInTube<F>> {
        let mut best: Option<RootInTube<F>> = None;
        self.for_each_root_in_tube(q, |inside| {
            if best.is_none_or(|best| nearer(&inside, &best)) {
                best = Some(inside);
            }
        });
        best
    }

    /// Where a world position lies in the light.
    pub fn locate(&self, point_in_world: DVec3) -> TubeLocation {
        let q = F::vec(self.placement.tube_from_world(point_in_world));
        let mut roots = Vec::new();
        self.for_each_root_in_tube(q, |root| roots.push(root.segment as f64 + root.u.f64()));
        TubeLocation { point: self.nearest_root(q).map(|root| self.tube_point(&root)), roots }
    }

    /// A root in the terms that people and files use.
    pub fn tube_point(&self, root: &TubeRoot<F>) -> TubePoint {
        let over_radius = |x: F| if root.radius > F::of(0.0) { (x / root.radius).f64() } else { 0.0 };
        TubePoint {
            segment: root.segment,
            u: root.u.f64(),
            t: root.t(),
            v: over_radius(root.v_len),
            w: over_radius(root.w_len),
            radius: root.radius.f64() * self.placement.world_per_tube,
            direction: self.placement.rotation * F::vec_f64(self.direction_at(root)),
        }
    }
}

/// Whether `a` has the smaller `|r| / R`; asked without dividing, since R may be zero (then r is zero too).
#[inline(always)]
fn nearer<F: Lanes>(a: &RootInTube<F>, b: &RootInTube<F>) -> F::Mask {
    (a.r2 * b.radius * b.radius).lt(b.r2 * a.radius * a.radius)
}

/// How near to the source light falls off no further, in world units.
fn least_distance(placement: &Placement) -> f64 {
    1e-6 * placement.world_per_tube
}

//! BendyLights: rays along curves of constant (v, w) in a tube.

use glam::DVec3;

use crate::arc::arc_length;
use crate::build::{self, Placement};
use crate::curve::Curve;
use crate::frame::perpendicular_up;
use crate::lanes::{Lanes, Mask, choose};
use crate::parameters::{DIRECTION, END_MODE, FRAME};
use crate::solve::{Roots, increasing_roots};
use crate::{
    ControlPoint, DirectionMode, EndMode, FrameMode, Light, LightCoords, LightError, LightProfile, Real, Segment,
};

/// Checked BendyLight, prepared for evaluation in `F` (light model, sections 1 to 6).
///
/// Everything is prepared in f64 and, for `f32`, rounded once. Geometry is in tube space, see [`Placement`].
///
/// Accuracy: for tubes with `R kappa <= 0.9` and `|P'| >= 0.1 L`, `L = |d0| + |d1|`, the error of the parameter of a
/// point at offset `r` is at most `16 eps cond`, `cond = (|r| + L) / (|P'| (1 - kappa r.N))`, `eps` 2^-52 or 2^-24,
/// times `1 + |world offset| / size` for world positions.
#[derive(Clone, Debug)]
pub struct Tube<F: Lanes> {
    /// Segments. With [`EndMode::Extend`] there is one more, whose parameter has no end.
    pub segments: Vec<Segment<F>>,
    /// Number of quadratic segments `n`: `t` runs from 0 to `n`, or further if the light is extended.
    pub n: usize,
    /// Position of tube space in the world.
    pub placement: Placement,
    /// Orientation of the cross-section.
    pub frame: FrameMode,
    /// Unit vector of the light's `up`, used if `frame` is [`FrameMode::Up`].
    pub up: F::Vec3,
    /// Mode of the direction of arrival.
    pub direction: DirectionMode,
    /// Profile. Its minimum distance is a millionth of the light's length.
    pub light_profile: LightProfile,
}

/// Root of a point inside the tube: a parameter whose cross-section contains the point. Lengths are in tube space.
#[derive(Clone, Copy, Debug)]
pub struct TubeRoot<F: Lanes> {
    /// Index of the segment; `n` on the extension.
    pub segment: usize,
    /// Parameter in the segment.
    pub u: F,
    /// `q - P(u)`.
    pub r: F::Vec3,
    /// `r . v_hat`, not divided by the radius, which may be zero.
    pub v_len: F,
    /// `r . w_hat`.
    pub w_len: F,
    pub radius: F,
    pub v_hat: F::Vec3,
    pub u_hat: F::Vec3,
}

impl<F: Real> TubeRoot<F> {
    pub fn t(&self) -> f64 {
        self.segment as f64 + self.u.f64()
    }
}

/// Root inside the tube whose frame is not computed yet. A search for the nearest root compares such roots.
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
    pub radius: F,
}

/// Tube coordinates of a point.
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
    /// Unit vector in world space from the surface towards the arriving light.
    pub direction: DVec3,
}

/// Location of a world position in a tube.
#[derive(Clone, Debug, PartialEq)]
pub struct TubeLocation {
    /// Tube coordinates; `None` outside the light. If distant parts of the tube overlap, those with the smallest
    /// `|r| / R`.
    pub point: Option<TubePoint>,
    /// Global parameter `t` of every root inside the tube, ascending. A root at a joint counts once.
    pub roots: Vec<f64>,
}

impl Tube<f64> {
    /// Checks and prepares a light. Folds, degenerate segments and numbers outside their domain are errors.
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

    /// Prepares `light`, from which this tube was made, with other control points, even if its tube folds then. Light has
    /// no direction in a fold, but a solver can find its way out of it. The result has the same bits as that of
    /// [`Tube::new`]. The light's other values are not checked again.
    pub fn with_points(&self, light: &Light, points: &[ControlPoint]) -> Result<Self, LightError> {
        let end_mode = light.get(END_MODE);
        let (segments, placement) = build::segments_of_points(points, light.transform(), self.up, end_mode, true)?;
        let light_profile = self.light_profile.clone().with_min_distance(light, least_distance(&placement));
        Ok(Self { segments, n: points.len() - 2, placement, light_profile, ..*self })
    }

    /// Returns the largest `R kappa` of each segment, below 1.
    pub fn r_kappa_max(&self) -> Vec<f64> {
        self.segments[..self.n].iter().map(|segment| crate::validity::r_kappa_max(&segment.curve)).collect()
    }

    /// Returns the light coordinates of a root.
    pub fn coords_at(&self, root: &TubeRoot<f64>) -> LightCoords {
        let TubePoint { t, v, w, direction, .. } = self.tube_point(root);
        LightCoords { t, v, w, s: self.path_length(root), direction }
    }

    /// Returns the irradiance at a root on a surface perpendicular to the light, linear RGB, without visibility.
    ///
    /// ```
    /// use glam::DVec3;
    /// use light::parameters::INTENSITY;
    /// use light::{Light, Tube, bend};
    ///
    /// // A spotlight decays by the square of the distance.
    /// let tube = Tube::new(&bend(&Light::spot().with(INTENSITY, 60.0), 3)?)?;
    /// let q = tube.placement.tube_from_world(DVec3::new(0.0, 0.0, -2.0));
    /// let root = tube.nearest_root(q).expect("on the axis");
    /// assert!(tube.irradiance(&root).distance(DVec3::splat(15.0)) < 1e-12);
    /// # Ok::<(), light::LightError>(())
    /// ```
    pub fn irradiance(&self, root: &TubeRoot<f64>) -> DVec3 {
        self.light_profile.irradiance(self.segments[root.segment].emission(root.u), &self.coords_at(root))
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
    /// Returns the end mode of the light, which follows from the segments.
    pub fn end_mode(&self) -> EndMode {
        if self.segments.len() > self.n { EndMode::Extend } else { EndMode::Cut }
    }

    /// Returns the largest `t` of the light; infinite if it is extended.
    pub fn t_end(&self) -> f64 {
        if self.end_mode() == EndMode::Extend { f64::INFINITY } else { self.n as f64 }
    }

    /// Returns the index of the segment at `t`, which is 0 or more, and the parameter in it. A joint lies in the later
    /// segment.
    ///
    /// ```
    /// use glam::DVec3;
    /// use light::{Light, Tube};
    ///
    /// // Samples the centre curve at t = 1.5 in the world.
    /// let points = (0..5).map(|k| DVec3::NEG_Z * f64::from(k)).collect();
    /// let tube = Tube::new(&Light::bendy(points, vec![0.1; 5]))?;
    /// let (segment, u) = tube.segment_at(1.5);
    /// let position = tube.placement.world_from_tube(tube.segments[segment].curve.position(u));
    /// assert_eq!((segment, u, position), (1, 0.5, DVec3::NEG_Z * 2.0));
    /// # Ok::<(), light::LightError>(())
    /// ```
    pub fn segment_at(&self, t: f64) -> (usize, f64) {
        let segment = (t as usize).min(self.segments.len() - 1);
        (segment, t - segment as f64)
    }

    /// Returns the value of `f` at the start of the first segment.
    #[inline(always)]
    pub fn first_joint(&self, q: F::Vec3) -> F {
        let first = &self.segments[0].curve;
        -F::dot(q - first.b0, first.d0)
    }

    /// Returns the value of `f` at the end of segment `i`. The two segments at a joint share it.
    #[inline(always)]
    pub fn end_joint(&self, i: usize, q: F::Vec3) -> F {
        let curve = &self.segments[i].curve;
        -F::dot(q - curve.b2, curve.d1)
    }

    /// Returns the candidate roots on segment `i`, whose ends have the values `f0` and `f1`. On the extension, `i = n`,
    /// the parameter has no upper limit.
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

    /// Evaluates the root at `u` of segment `i`. The mask is true if the point lies inside the tube: `|r| <= R`.
    #[inline(always)]
    pub fn inside_at(&self, i: usize, q: F::Vec3, u: F) -> (RootInTube<F>, F::Mask) {
        let curve = &self.segments[i].curve;
        let (r, radius) = (curve.offset(q, u), curve.radius(u));
        let r2 = F::dot(r, r);
        let is_inside = radius.ge(F::of(0.0)) & r2.le(radius * radius);
        (RootInTube { segment: i, u, r, r2, radius }, is_inside)
    }

    /// Computes the frame and the cross-section coordinates of a root.
    #[inline(always)]
    pub fn root_at(&self, inside: &RootInTube<F>) -> TubeRoot<F> {
        let RootInTube { segment, u, r, radius, .. } = *inside;
        let curve = &self.segments[segment].curve;
        let u_hat = curve.u_hat(u);
        let (v_hat, w_hat) = self.cross_section(curve, u_hat);
        TubeRoot { segment, u, r, v_len: F::dot(r, v_hat), w_len: F::dot(r, w_hat), radius, v_hat, u_hat }
    }

    /// Computes `(v_hat, w_hat)` across the unit tangent, in the light's frame mode.
    #[inline(always)]
    pub fn cross_section(&self, curve: &Curve<F>, u_hat: F::Vec3) -> (F::Vec3, F::Vec3) {
        if self.frame == FrameMode::RotationMinimizing {
            return curve.rotation_minimizing(u_hat);
        }
        let w_hat = perpendicular_up::<F>(self.up, u_hat);
        (F::cross(w_hat, u_hat), w_hat)
    }

    /// Returns the unit direction in tube space from the surface towards the arriving light, in the light's direction
    /// mode (light model, section 3, times R).
    #[inline(always)]
    pub fn direction_at(&self, root: &TubeRoot<F>) -> F::Vec3 {
        self.direction_by(self.direction, root)
    }

    /// Returns the unit direction by the tangent of the light path, whatever the light's mode. Visibility follows this
    /// path.
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
        choose!(F::select_vec, length.lt(F::DIRECTION_FLOOR), -u_hat, tangent * (F::of(-1.0) / length))
    }

    /// Returns the rotation `tau` of the frame about the tangent per unit of u; zero for the rotation-minimising frame.
    #[inline(always)]
    pub fn twist(&self, root: &TubeRoot<F>, u_hat_derivative: F::Vec3) -> F {
        if self.frame == FrameMode::RotationMinimizing {
            return F::of(0.0);
        }
        let along = F::dot(self.up, root.u_hat);
        let length = F::length(self.up - root.u_hat * along).most(F::of(1e-6));
        along * F::dot(u_hat_derivative, root.v_hat) / length
    }

    /// Returns the length of the light path to a root, `sqrt(s_c^2 + |r|^2)` in world units, with `s_c` the arc length
    /// along the curve.
    #[inline(always)]
    pub fn path_length(&self, root: &TubeRoot<F>) -> F {
        let segment = &self.segments[root.segment];
        let along = segment.arc_start + arc_length(&segment.curve, root.u);
        (along * along + F::dot(root.r, root.r)).sqrt() * F::of(self.placement.world_per_tube)
    }
}

impl<F: Real> Tube<F> {
    /// Calls `found` with every root inside the tube of the tube-space point `q`, in ascending t. A root at a joint is
    /// reported once.
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

    /// Returns the root with the smallest `|r| / R`, which is the one that counts (light model, section 5).
    pub fn nearest_root(&self, q: F::Vec3) -> Option<TubeRoot<F>> {
        let mut best: Option<RootInTube<F>> = None;
        self.for_each_root_in_tube(q, |inside| {
            if best.is_none_or(|best| nearer(&inside, &best)) {
                best = Some(inside);
            }
        });
        best.map(|inside| self.root_at(&inside))
    }

    /// Locates a world position in the light.
    ///
    /// ```
    /// use glam::DVec3;
    /// use light::{Light, Tube, bend};
    ///
    /// let tube = Tube::new(&bend(&Light::spot(), 2)?)?;
    /// let point = tube.locate(DVec3::new(0.0, 0.0, -0.5)).point.expect("on the axis");
    /// assert_eq!((point.t, point.v, point.w), (1.0, 0.0, 0.0));
    /// assert_eq!(point.direction, DVec3::Z);
    /// assert_eq!(tube.locate(DVec3::X).point, None);
    /// # Ok::<(), light::LightError>(())
    /// ```
    pub fn locate(&self, point_in_world: DVec3) -> TubeLocation {
        let q = F::vec(self.placement.tube_from_world(point_in_world));
        let mut roots = Vec::new();
        self.for_each_root_in_tube(q, |root| roots.push(root.segment as f64 + root.u.f64()));
        TubeLocation { point: self.nearest_root(q).map(|root| self.tube_point(&root)), roots }
    }

    /// Converts a root to tube coordinates, in radii and world units.
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

/// Returns true if `a` has the smaller `|r| / R`. The test avoids a division, since R may be zero (then r is zero too).
#[inline(always)]
fn nearer<F: Lanes>(a: &RootInTube<F>, b: &RootInTube<F>) -> F::Mask {
    (a.r2 * b.radius * b.radius).lt(b.r2 * a.radius * a.radius)
}

/// Returns the minimum distance from the source for decay, in world units.
fn least_distance(placement: &Placement) -> f64 {
    1e-6 * placement.world_per_tube
}

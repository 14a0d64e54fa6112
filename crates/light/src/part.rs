//! Part of a light near a scene, as a light of its own.
//!
//! Single precision holds a position in a light to about 1e-7 of the light's length. If a light is 10,000 times as long
//! as the scene, that is a thousandth of the scene: shadows and profile turn to noise. So single precision gets only
//! the part of the light that can matter to the scene. It is cut out in double precision by blossoming. Its tube space
//! has the origin at the scene and the part's length as its unit.

use glam::DVec3;

use crate::arc::arc_length;
use crate::build::Placement;
use crate::{Curve, Segment, Tube, TubeLocation, TubePoint};

/// Largest span of t that one segment of a part may cover. If a larger one were needed, the part would gain four bits
/// of precision or fewer, and the light stays whole.
const WIDEST_SPAN: f64 = 1.0 / 16.0;
/// Size to which the search for a part refines intervals, as a share of the box.
const LEAF: f64 = 0.25;
/// Maximum number of times that the search halves a segment. What remains counts as a point.
const MAX_HALVINGS: u32 = 40;
/// Span of t after `MAX_HALVINGS` halvings of a segment.
const LEAST_SPAN: f64 = 1.0 / (1_u64 << MAX_HALVINGS) as f64;
/// Share by which boxes are enlarged: far more than the rounding errors of single precision.
const MARGIN: f64 = 0.01;

/// Part of a light, or all of it. Its segments are equal spans of the light's t.
#[derive(Clone, Debug)]
pub struct LightPart {
    /// Tube of the part. It ends where it was cut, and has no extension.
    pub tube: Tube<f64>,
    /// Value of t of the whole light at the start of the part.
    pub t_start: f64,
    /// Span of the whole light's t per unit of the part's t: a power of two.
    pub t_span: f64,
    /// Index of the whole light's last segment, the extension included.
    last: usize,
}

/// Box of any orientation in tube space.
struct OrientedBox {
    center: DVec3,
    half_axes: [DVec3; 3],
}

impl Tube<f64> {
    /// Returns the part of the light that can contain any point within `half_extent` of a world position.
    ///
    /// For each such point the part has the same roots as the light, with the same radius, frame, colour and decay. The
    /// result is the whole light if that is not much longer than the box, or does not reach it.
    pub fn part_near(&self, center_in_world: DVec3, half_extent: DVec3) -> LightPart {
        let region = OrientedBox::new(&self.placement, center_in_world, half_extent);
        let range = self.range_near(&region).filter(|(start, end)| end - start <= WIDEST_SPAN);
        let last = self.segments.len() - 1;
        let Some((start, end)) = range else {
            return LightPart { tube: self.clone(), t_start: 0.0, t_span: 1.0, last };
        };
        // A power of two, and whole multiples of it, so that values shared by two segments at a joint stay equal to the
        // last bit.
        let span = power_of_two_above((end - start).max(LEAST_SPAN));
        let first = (start / span).floor();
        let count = ((end / span).ceil().max(first + 1.0) - first) as usize;
        let pieces: Vec<_> = (0..count).map(|k| self.piece_at((first + k as f64) * span, span)).collect();
        let length = pieces.iter().map(|piece| piece.curve.d0.length() + piece.curve.d1.length()).fold(0.0, f64::max);
        let unit = power_of_two_above(length.max(f64::MIN_POSITIVE));
        let segments: Vec<_> = pieces.iter().map(|piece| rebased(piece, region.center, unit)).collect();
        let placement = Placement {
            translation: center_in_world,
            rotation: self.placement.rotation,
            world_per_tube: self.placement.world_per_tube * unit,
        };
        let tube = Self { n: segments.len(), segments, placement, ..self.clone() };
        LightPart { tube, t_start: first * span, t_span: span, last }
    }

    /// Returns [`Self::part_near`] for the box around some world positions.
    pub fn part_near_points(&self, points_in_world: &[DVec3]) -> LightPart {
        let (low, high) = points_in_world
            .iter()
            .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &point| (low.min(point), high.max(point)));
        self.part_near(low / 2.0 + high / 2.0, high / 2.0 - low / 2.0)
    }

    /// Returns the smallest and largest t of possible roots of points of the region; `None` if there are none.
    fn range_near(&self, region: &OrientedBox) -> Option<(f64, f64)> {
        let ranges = self.segments.iter().enumerate().filter_map(|(i, segment)| {
            let (start, end) = if i == self.n {
                region.u_range_on_extension(&segment.curve)
            } else {
                region.u_range_on(&segment.curve, (0.0, 1.0), MAX_HALVINGS)
            }?;
            Some((i as f64 + start, i as f64 + end))
        });
        ranges.reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
    }

    /// Returns the piece of `span` that starts at `t`. It lies in one segment.
    fn piece_at(&self, t: f64, span: f64) -> Segment<f64> {
        let (index, start) = self.segment_at(t);
        let whole = &self.segments[index];
        let end = t + span - index as f64;
        let mut curve = whole.curve.subcurve(start, end);
        // Both segments at a joint share this point to the last bit.
        if end == 1.0 && index < self.n {
            curve.b2 = whole.curve.b2;
        }
        Segment {
            curve,
            color: blossomed(whole.color, start, end),
            intensity: blossomed(whole.intensity, start, end),
            arc_start: whole.arc_start + arc_length(&whole.curve, start),
        }
    }
}

impl LightPart {
    /// Converts a location in the part to a location in the whole light.
    pub fn to_whole_light(&self, location: &TubeLocation) -> TubeLocation {
        let point = location.point.as_ref().map(|point| {
            let start = self.t_start + self.t_span * point.segment as f64;
            let segment = (start.floor() as usize).min(self.last);
            let u = start - segment as f64 + self.t_span * point.u;
            TubePoint { segment, u, t: segment as f64 + u, ..*point }
        });
        TubeLocation { point, roots: location.roots.iter().map(|t| self.t_start + self.t_span * t).collect() }
    }
}

impl OrientedBox {
    fn new(placement: &Placement, center_in_world: DVec3, half_extent: DVec3) -> Self {
        // A box without extent still has the rounding of its position.
        let least = 1e-12 * (center_in_world - placement.translation).length();
        let half = half_extent * (1.0 + MARGIN) + least;
        let axis = |axis: DVec3| placement.rotation.transpose() * axis / placement.world_per_tube;
        Self {
            center: placement.tube_from_world(center_in_world),
            half_axes: [DVec3::X * half.x, DVec3::Y * half.y, DVec3::Z * half.z].map(axis),
        }
    }

    fn size(&self) -> f64 {
        self.half_axes.iter().map(|axis| axis.length()).sum()
    }

    /// Returns the half extent of the region along `axis`, times the length of `axis`.
    fn half_extent_along(&self, axis: DVec3) -> f64 {
        self.half_axes.iter().map(|half| half.dot(axis).abs()).sum()
    }

    /// Returns the range of u of possible roots on a part of a curve.
    fn u_range_on(&self, curve: &Curve<f64>, (start, end): (f64, f64), halvings: u32) -> Option<(f64, f64)> {
        let piece = curve.subcurve(start, end);
        if !self.may_be_perpendicular_to(&piece) || !self.intersects_tube_box(&piece) {
            return None;
        }
        if halvings == 0 || piece.d0.length() + piece.d1.length() <= LEAF * self.size() {
            return Some((start, end));
        }
        let middle = f64::midpoint(start, end);
        let halves = [(start, middle), (middle, end)].map(|half| self.u_range_on(curve, half, halvings - 1));
        match halves {
            [Some((start, _)), Some((_, end))] => Some((start, end)),
            [one, other] => one.or(other),
        }
    }

    /// Returns true if `f(u) = -(q - P(u)) . d(u)` can be zero on the piece for a point q of the region. The four
    /// Bernstein coefficients of f, each linear in q, bound it.
    fn may_be_perpendicular_to(&self, piece: &Curve<f64>) -> bool {
        let (from_start, from_end) = (self.center - piece.b0, self.center - piece.b2);
        let (d0, d1, a) = (piece.d0, piece.d1, piece.a);
        let (f0, f1) = (-from_start.dot(d0), -from_end.dot(d1));
        // The derivatives at the ends, 2 d . d - (q - P) . a, give the inner ones.
        let slope0 = 2.0 * d0.length_squared() - from_start.dot(a);
        let slope1 = 2.0 * d1.length_squared() - from_end.dot(a);
        let coefficients = [(f0, d0), (f0 + slope0 / 3.0, d0 + a / 3.0), (f1 - slope1 / 3.0, d1 - a / 3.0), (f1, d1)];
        let above = coefficients.iter().all(|&(f, d)| f > self.half_extent_along(d));
        let below = coefficients.iter().all(|&(f, d)| f < -self.half_extent_along(d));
        !above && !below
    }

    fn intersects_tube_box(&self, piece: &Curve<f64>) -> bool {
        let bounds = &piece.bounds;
        let between = self.center - bounds.center;
        (0..3).all(|k| between.dot(bounds.axes[k]).abs() <= bounds.half[k] + self.half_extent_along(bounds.axes[k]))
    }

    /// Returns the range of u of possible roots on the extension, which is straight and has no end.
    fn u_range_on_extension(&self, extension: &Curve<f64>) -> Option<(f64, f64)> {
        let d = extension.d0;
        let along = (self.center - extension.b0).dot(d);
        let u = |along: f64| along / (2.0 * d.length_squared());
        let (start, end) = (u(along - self.half_extent_along(d)), u(along + self.half_extent_along(d)));
        (end > 0.0).then_some((start.max(0.0), end))
    }
}

/// Returns the control values over `[start, end]` of a quadratic with the control values `c` over `[0, 1]`.
fn blossomed<T>(c: [T; 3], start: f64, end: f64) -> [T; 3]
where
    T: Copy + std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let at = |s: f64, e: f64| c[0] * ((1.0 - s) * (1.0 - e)) + c[1] * (s * (1.0 - e) + e * (1.0 - s)) + c[2] * (s * e);
    [at(start, start), at(start, end), at(end, end)]
}

/// Moves a segment to a tube space with another origin and unit. The unit is a power of two.
fn rebased(segment: &Segment<f64>, origin: DVec3, unit: f64) -> Segment<f64> {
    let curve = &segment.curve;
    let mut moved = Curve {
        b0: (curve.b0 - origin) / unit,
        b2: (curve.b2 - origin) / unit,
        d0: curve.d0 / unit,
        d1: curve.d1 / unit,
        a: curve.a / unit,
        r0: curve.r0 / unit,
        e0: curve.e0 / unit,
        ar: curve.ar / unit,
        ..*curve
    };
    moved.bounds = moved.tube_box();
    Segment { curve: moved, arc_start: segment.arc_start / unit, ..*segment }
}

/// Returns the least power of two that is at least `x`.
fn power_of_two_above(x: f64) -> f64 {
    libm::ldexp(1.0, libm::ceil(libm::log2(x)) as i32)
}

//! Intersection of a bent path with the scene.

use glam::DVec3;

use crate::hierarchy::ThickLine;
use crate::{Aabb64, BentPath, Bvh, Chord, Triangle};

/// Intersection of a path with a triangle.
#[derive(Clone, Copy, Debug)]
pub struct BentHit {
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    /// Parameter t of the light at the point.
    pub t: f64,
    /// Position in scene space.
    pub position: DVec3,
    /// Barycentric weights of the triangle's corners at the point.
    pub barycentrics: DVec3,
}

/// Length in u below which a path that touches a plane without crossing it counts as a miss.
const MIN_CROSSING_U: f64 = 1e-9;

/// Cost in steps of a segment to subdivide and of a chord to test. A box costs one step.
const STEPS_OF_SEGMENT: u64 = 10;
const STEPS_OF_CHORD: u64 = 10;

impl Bvh {
    /// Finds the first triangle from the source on that the path meets before `t_end` and that `accept` takes. Both
    /// sides of triangles count. The hit shadows everything further along the path.
    ///
    /// Accuracy: the hit lies on the path and on the triangle's plane. The error of t is some ulps over the cosine
    /// between them. A path that touches a plane for less than 1e-9 of a segment may count as a miss.
    pub fn first_bent_hit(&self, path: &BentPath, t_end: f64, accept: impl Fn(&BentHit) -> bool) -> Option<BentHit> {
        self.first_bent_hit_budgeted(path, t_end, |_| true, accept)
    }

    /// Finds the first triangle as `Self::first_bent_hit` does, and counts steps as [`Self::first_hit_budgeted`]
    /// does. Segments and chords also cost steps.
    pub fn first_bent_hit_budgeted(
        &self,
        path: &BentPath,
        t_end: f64,
        spend: impl Fn(u64) -> bool,
        accept: impl Fn(&BentHit) -> bool,
    ) -> Option<BentHit> {
        self.first_bent_hit_in_bounds(path, t_end, &self.hierarchy.bounds()?, &spend, &accept, false)
    }

    /// Finds the first triangle as `Self::first_bent_hit_budgeted` does, among the triangles within `bounds`. With
    /// `any` it finds any triangle instead.
    pub(crate) fn first_bent_hit_in_bounds(
        &self,
        path: &BentPath,
        t_end: f64,
        bounds: &Aabb64,
        spend: &impl Fn(u64) -> bool,
        accept: &impl Fn(&BentHit) -> bool,
        any: bool,
    ) -> Option<BentHit> {
        if !spend(STEPS_OF_SEGMENT * path.tube.segments.len() as u64) {
            return None;
        }
        let mut best = None;
        path.for_each_chord(t_end, bounds, |chord| {
            if !spend(STEPS_OF_CHORD) {
                return true;
            }
            best = self.first_on_chord(path, chord, spend, accept, any);
            best.is_some()
        });
        best
    }

    /// Returns true if the path meets any triangle before `t_end` that `accept` takes.
    pub fn has_bent_hit(&self, path: &BentPath, t_end: f64, accept: impl Fn(&BentHit) -> bool) -> bool {
        let Some(bounds) = self.hierarchy.bounds() else { return false };
        self.first_bent_hit_in_bounds(path, t_end, &bounds, &|_| true, &accept, true).is_some()
    }

    fn first_on_chord(
        &self,
        path: &BentPath,
        chord: &Chord,
        spend: &impl Fn(u64) -> bool,
        accept: &impl Fn(&BentHit) -> bool,
        any: bool,
    ) -> Option<BentHit> {
        let [from, to] = chord.ends;
        let [start, end] = chord.u;
        let line = ThickLine { from, to, radius: chord.error() };
        let mut best: Option<BentHit> = None;
        let mut limit = 1.0;
        self.hierarchy.visit_along_line(line, spend, |triangle| {
            if any && best.is_some() {
                return -1.0;
            }
            let accepted =
                |hit: &BentHit| best.is_none_or(|best| (hit.t, hit.triangle) < (best.t, best.triangle)) && accept(hit);
            if let Some(hit) = intersect_chord(path, chord, triangle, &self.triangle(triangle), accepted) {
                // No nearer hit starts beyond this share: chord and path are compared at equal u.
                limit = (hit.t - chord.segment as f64 - start) / (end - start);
                best = Some(hit);
            }
            limit
        });
        best
    }
}

/// Finds the first accepted point of `chord`'s path on the triangle.
///
/// `g(u) = N . (C(u) - corner)` changes sign where the path crosses the plane, and `|g''| <= |N| bend`. With this bound
/// the values at two ends decide between no crossing, one crossing and further subdivision.
fn intersect_chord(
    path: &BentPath,
    chord: &Chord,
    index: usize,
    triangle: &Triangle,
    accept: impl Fn(&BentHit) -> bool,
) -> Option<BentHit> {
    let normal = triangle.normal();
    if normal == DVec3::ZERO {
        return None;
    }
    let corner = triangle.corners[0];
    let size = chord.ends.iter().map(|end| end.length()).fold(corner.length(), f64::max);
    let rounding = 32.0 * f64::EPSILON * normal.length() * size;
    let plane = Plane { path, segment: chord.segment, normal, corner, rounding };
    let ends = std::array::from_fn(|k| (chord.u[k], normal.dot(chord.ends[k] - plane.corner)));
    plane.first_crossing(ends, normal.length() * chord.second_derivative_bound, &|u| {
        let position = path.position_at(chord.segment, u);
        let weights = triangle.barycentrics_at(position)?;
        let t = chord.segment as f64 + u;
        let hit = BentHit { triangle: index, t, position, barycentrics: weights };
        accept(&hit).then_some(hit)
    })
}

/// Plane of a triangle that a path may cross.
struct Plane<'a> {
    path: &'a BentPath<'a>,
    segment: usize,
    normal: DVec3,
    corner: DVec3,
    /// Greatest height over the plane that rounding gives a point of the plane.
    rounding: f64,
}

impl Plane<'_> {
    fn height(&self, u: f64) -> f64 {
        self.normal.dot(self.path.position_at(self.segment, u) - self.corner)
    }

    /// Returns the first value that `take` returns for a crossing of the path with the plane, between two parameters
    /// whose heights over the plane are given. `bend` bounds the second derivative of the height.
    fn first_crossing<T>(
        &self,
        [low, high]: [(f64, f64); 2],
        bend: f64,
        take: &impl Fn(f64) -> Option<T>,
    ) -> Option<T> {
        let ((u0, g0), (u1, g1)) = (low, high);
        let h = u1 - u0;
        // An infinite straight piece has no bend: 0 times its length squared is 0.
        let deviation = if bend == 0.0 { 0.0 } else { bend * h * h };
        let crosses = (g0 <= 0.0) != (g1 <= 0.0);
        if !crosses && g0.abs().min(g1.abs()) > deviation / 8.0 {
            return None;
        }
        // The slope differs from its mean by less than `deviation / h`. If it cannot vanish, there is one crossing.
        let steady = (g1 - g0).abs() > deviation;
        if crosses && (steady || h < MIN_CROSSING_U) {
            return take(self.crossing(low, high));
        }
        if steady || h < MIN_CROSSING_U {
            return None;
        }
        // A path in the plane does not cross it and would be subdivided without end. Five points detect it: no path
        // crosses a plane that often in a chord.
        let level = |share: f64| self.height(u0 + share * h).abs() <= self.rounding;
        if g0.abs().max(g1.abs()) <= self.rounding && [0.25, 0.5, 0.75].into_iter().all(level) {
            return None;
        }
        let middle = f64::midpoint(u0, u1);
        let middle = (middle, self.height(middle));
        self.first_crossing([low, middle], bend, take).or_else(|| self.first_crossing([middle, high], bend, take))
    }

    /// Finds the crossing between two parameters whose heights have different signs, by false position with the
    /// Illinois rule: superlinear, and never outside the bracket.
    fn crossing(&self, low: (f64, f64), high: (f64, f64)) -> f64 {
        let (mut a, mut b) = (low, high);
        for _ in 0..64 {
            if b.1 == 0.0 || a.1 == b.1 {
                break;
            }
            let u = b.0 - b.1 * (b.0 - a.0) / (b.1 - a.1);
            if (u - b.0).abs() <= f64::EPSILON * b.0.abs() {
                break;
            }
            let next = (u, self.height(u));
            if (next.1 <= 0.0) == (b.1 <= 0.0) {
                a.1 *= 0.5;
            } else {
                a = b;
            }
            b = next;
        }
        b.0
    }
}

//! Fits a bent map to the casters: on each face, and along the light.
//!
//! The fit tests pieces of the tube against boxes around the scene's triangles. In a piece the curve is planar. A
//! point's distance N from that plane is linear in position. Its distance M from the curve within the plane follows
//! from its distance to the tangent at the piece's middle. V and W are N and M rotated about the tangent.

use glam::{DMat3, DVec3};
use light::{Curve, FrameMode, Tube, TubeSlab, quadratic_range};

use super::faces::{Faces, MAX_FACES};
use crate::casters::{ClusterBounds, Clusters, MapCover, OpenSide, OpenSides};
use crate::settings::{Culling, MARGIN_TEXELS, SMALLEST_RATIO, SMALLEST_SHARE};

/// Number of pieces per slab. A slab turns by at most 15 degrees.
const PIECES: u32 = 4;
/// Margin of bounds as a share of the light's size, for rounding here and on the GPU.
const ROUNDING: f64 = 1e-6;

/// Interval of numbers: the least and the greatest.
type Range = [f64; 2];

/// Part of a light that its shadow map shows: the part that may contain casters.
#[derive(Clone, Copy, Debug)]
pub(super) struct BendyFit {
    pub faces: Faces,
    /// x / depth and y / depth on each face; `None` for a face without casters.
    pub bounds: [Option<[Range; 2]>; MAX_FACES],
    /// Range of t that may contain casters; `None` if the light contains no caster.
    pub t: Option<Range>,
    /// Sides of the casters' bounds that may cast shadows.
    pub open_sides: OpenSides,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct DrawnFace {
    pub center: [f64; 2],
    /// Half the size of the drawn part.
    pub half: [f64; 2],
}

impl BendyFit {
    /// Fits a map to `clusters`, which are boxes in scene space. An extended tube ends at `t_max`.
    pub fn new(
        tube: &Tube<f64>,
        faces: Faces,
        t_max: f64,
        scene_origin: DVec3,
        clusters: &Clusters,
        culling: Culling,
    ) -> Self {
        let pieces = pieces(tube, t_max, scene_origin);
        let comes_in = |side: &OpenSide| !culling.sides || may_enter(&pieces, tube, side, scene_origin);
        let open_sides = clusters.open_sides(comes_in);
        let mut fit = Self { faces, bounds: [None; MAX_FACES], t: None, open_sides };
        for piece in &pieces {
            fit.extend_by_leaves(clusters.casting_trees(open_sides), |cluster| {
                piece.bounds_of(cluster).map(|range| Self::of(faces, &range))
            });
        }
        fit
    }

    /// Makes a fit to the whole light up to `t_max`, with all casters.
    pub fn whole(faces: Faces, clusters: &Clusters, t_max: f64) -> Self {
        let open_sides = clusters.open_sides(|_| true);
        Self { faces, bounds: [None; MAX_FACES], t: Some([0.0, t_max]), open_sides }
    }

    fn of(faces: Faces, coords: &CoordsRange) -> Self {
        let depth = coords.radius.map(|r| r / faces.slope());
        let open_sides = OpenSides::default();
        let mut fit = Self { faces, bounds: [None; MAX_FACES], t: Some(coords.t), open_sides };
        for (face, bounds) in fit.bounds.iter_mut().enumerate().take(faces.count()) {
            let opposite = |[low, high]: Range| [-high, -low];
            let [x, y, ahead] = match face {
                0 => [coords.v, coords.w, depth],
                1 => [coords.w, depth, coords.v],
                2 => [coords.w, depth, opposite(coords.v)],
                3 => [coords.v, depth, coords.w],
                _ => [coords.v, depth, opposite(coords.w)],
            };
            *bounds = slopes([x, y], ahead, faces.limits(face));
        }
        fit
    }

    /// Returns the drawn part of a face of `side` texels. It stays within the tube, whose rim is the border of the map.
    /// At an edge shared with another face it extends as far as the filter reads.
    pub fn drawn(&self, face: usize, side: f64) -> DrawnFace {
        let limits = self.faces.limits(face);
        let grown = side / (side - 2.0 * MARGIN_TEXELS);
        let bounds = self.bounds[face].unwrap_or(limits);
        let size = [0, 1].map(|axis| bounds[axis][1] - bounds[axis][0]);
        let least = size[0].max(size[1]) * SMALLEST_RATIO;
        let mut drawn = DrawnFace { center: [0.0; 2], half: [0.0; 2] };
        for axis in 0..2 {
            let [low, high] = limits[axis];
            let rim = |slope: f64| !self.faces.is_cube() || slope.abs() < 1.0;
            let reach = (high - low) / 2.0 * (grown - 1.0);
            let [low, high] = [if rim(low) { low } else { low - reach }, if rim(high) { high } else { high + reach }];
            let half = size[axis].max(least).max((high - low) * SMALLEST_SHARE) / 2.0 * grown;
            let half = half.min((high - low) / 2.0);
            let middle = f64::midpoint(bounds[axis][0], bounds[axis][1]);
            (drawn.center[axis], drawn.half[axis]) = (middle.clamp(low + half, (high - half).max(low + half)), half);
        }
        drawn
    }
}

impl MapCover for BendyFit {
    fn contains(&self, other: &Self) -> bool {
        let within = |outer: Range, inner: Range| outer[0] <= inner[0] && inner[1] <= outer[1];
        let mut faces = self.bounds.iter().zip(other.bounds);
        let contains_faces = faces.all(|(own, other)| match (own, other) {
            (Some(a), Some(b)) => within(a[0], b[0]) && within(a[1], b[1]),
            (own, other) => own.is_some() || other.is_none(),
        });
        contains_faces && matches!((self.t, other.t), (Some(a), Some(b)) if within(a, b))
    }

    fn extend(&mut self, other: &Self) {
        let union = |[a, b]: Range, [c, d]: Range| [a.min(c), b.max(d)];
        for (own, other) in self.bounds.iter_mut().zip(other.bounds) {
            *own = match (*own, other) {
                (Some(a), Some(b)) => Some([union(a[0], b[0]), union(a[1], b[1])]),
                (a, b) => a.or(b),
            };
        }
        self.t = match (self.t, other.t) {
            (Some(a), Some(b)) => Some(union(a, b)),
            (a, b) => a.or(b),
        };
    }
}

fn pieces(tube: &Tube<f64>, t_max: f64, scene_origin: DVec3) -> Vec<TubePiece> {
    let share = |k: u32| f64::from(k) / f64::from(PIECES);
    light::slabs(tube, t_max, ROUNDING)
        .iter()
        .flat_map(|slab| (0..PIECES).map(|k| TubePiece::new(tube, slab, [share(k), share(k + 1)], scene_origin)))
        .collect()
}

/// True if light may enter the scene's bounds through a side. False if light only leaves through it.
fn may_enter(pieces: &[TubePiece], tube: &Tube<f64>, side: &OpenSide, scene_origin: DVec3) -> bool {
    !pieces.iter().all(|piece| piece.only_leaves_through(tube, side, scene_origin))
}

/// Returns the ranges of x / depth and y / depth within `limits`. `None` if one is empty.
fn slopes(aside: [Range; 2], depth: Range, limits: [Range; 2]) -> Option<[Range; 2]> {
    // Depth on a face is at least the distance from the axis divided by the face's limit.
    let nearest = aside
        .iter()
        .zip(limits)
        .map(|([low, high], [least, most])| low.max(-high).max(0.0) / least.abs().max(most.abs()));
    let [near, far] = [nearest.fold(depth[0].max(0.0), f64::max), depth[1]];
    if !(far > 0.0 && near <= far) {
        return None;
    }
    let mut slopes = limits;
    for (slope, [low, high]) in slopes.iter_mut().zip(aside) {
        // At depth 0 any slope is possible.
        let over = |x: f64, depth: f64| if depth > 0.0 { x / depth } else { x * f64::INFINITY };
        let least = if low > 0.0 {
            low / far
        } else if low == 0.0 {
            0.0
        } else {
            over(low, near)
        };
        let most = if high < 0.0 {
            high / far
        } else if high == 0.0 {
            0.0
        } else {
            over(high, near)
        };
        *slope = [slope[0].max(least), slope[1].min(most)];
        if slope[0] > slope[1] {
            return None;
        }
    }
    Some(slopes)
}

/// Bounds of the tube coordinates of a box's points within a piece.
struct CoordsRange {
    v: Range,
    w: Range,
    radius: Range,
    t: Range,
}

/// A short piece of the tube. Each linear function of position is a normal in scene space and an offset.
struct TubePiece {
    curve: Curve<f64>,
    t_start: f64,
    t_span: f64,
    /// Distance past the plane perpendicular to the curve at the start.
    past_start: (DVec3, f64),
    /// Distance past the plane perpendicular to the curve at the end.
    past_end: (DVec3, f64),
    /// Distance N from the curve's plane.
    normal: (DVec3, f64),
    /// Distance from the start along the tangent at the middle.
    along: (DVec3, f64),
    /// Distance from that tangent, in the curve's plane.
    across: (DVec3, f64),
    /// (d, a) of the curve `u (2 d + u a)` along and across that tangent.
    in_plane: [(f64, f64); 2],
    /// Cosine and sine of the tangent's largest angle to the middle tangent.
    turn: (f64, f64),
    /// V and W are `(alpha N + beta M, beta N - alpha M)`, rotated by at most `twist` radians.
    alpha: f64,
    beta: f64,
    twist: f64,
}

impl TubePiece {
    fn new(tube: &Tube<f64>, slab: &TubeSlab, [start, end]: Range, scene_origin: DVec3) -> Self {
        let curve = slab.slab_curve.subcurve(start, end);
        let placement = &tube.placement;
        let to_tube: DMat3 = placement.rotation.transpose() * (1.0 / placement.world_per_tube);
        let origin = placement.tube_from_world(scene_origin);
        let linear = |direction: DVec3, from: DVec3| (to_tube.transpose() * direction, direction.dot(origin - from));
        let (first, middle, last) = (curve.u_hat(0.0), curve.u_hat(0.5), curve.u_hat(1.0));
        let m_hat = curve.n_hat.cross(middle).normalize_or_zero();
        let cos = first.dot(middle).min(last.dot(middle)).clamp(0.0, 1.0);
        let sin = (1.0 - cos * cos).sqrt();
        let (v_hat, _) = tube.cross_section(&curve, middle);
        let twist = if tube.frame == FrameMode::Up {
            // The frame rotates about the tangent by `cot` of the angle between tangent and "up" per radian of bend.
            let turn = libm::acos(cos);
            let angle = libm::atan2(tube.up.cross(middle).length(), tube.up.dot(middle).abs()) - turn;
            if angle > 0.0 { turn / libm::tan(angle) } else { f64::INFINITY }
        } else {
            0.0
        };
        Self {
            past_start: linear(first, curve.b0),
            past_end: linear(last, curve.b2),
            normal: linear(curve.n_hat, curve.b0),
            along: linear(middle, curve.b0),
            across: linear(m_hat, curve.b0),
            in_plane: [middle, m_hat].map(|axis| (curve.d0.dot(axis), curve.a.dot(axis))),
            turn: (cos, sin),
            alpha: v_hat.dot(curve.n_hat),
            beta: v_hat.dot(m_hat),
            twist,
            t_start: slab.t_start + slab.t_span * start,
            t_span: slab.t_span * (end - start),
            curve,
        }
    }

    /// Bounds of the box's points that are in the piece; `None` if no point is.
    fn bounds_of(&self, cluster: &ClusterBounds) -> Option<CoordsRange> {
        let range = |(normal, offset): (DVec3, f64)| {
            let [low, high] = cluster.range(normal, offset);
            let slack = ROUNDING * (1.0 + low.abs().max(high.abs()));
            [low - slack, high + slack]
        };
        if range(self.past_start)[1] < 0.0 || range(self.past_end)[0] > 0.0 {
            return None;
        }
        let largest = self.radius([0.0, 1.0])[1];
        let normal = range(self.normal);
        if distance(normal) > largest {
            return None;
        }
        // A point off the axis of a tangent that turns shifts along the middle tangent.
        let (cos, sin) = self.turn;
        let shift = largest * sin;
        let [low, high] = range(self.along);
        let u = [self.parameter(low - shift), self.parameter(high + shift)];
        let radius = self.radius(u);
        let sagitta = quadratic_on(0.0, self.in_plane[1], u);
        let [low, high] = range(self.across);
        let grow = |x: f64, outward: bool| if outward { x / cos } else { x };
        let (low, high) = (low - sagitta[1], high - sagitta[0]);
        let in_plane = [grow(low, low < 0.0), grow(high, high > 0.0)];
        if libm::hypot(distance(normal), distance(in_plane)) > radius[1] {
            return None;
        }
        let (alpha, beta) = (self.alpha, self.beta);
        let (v, w) = (linear_range(normal, alpha, in_plane, beta), linear_range(normal, beta, in_plane, -alpha));
        let (v, w) = turned(v, w, self.twist);
        let t = u.map(|u| self.t_start + self.t_span * u);
        Some(CoordsRange { v: within(v, radius[1]), w: within(w, radius[1]), radius, t })
    }

    /// True if every light path in the piece leaves outwards through `side`, or is well inside it.
    ///
    /// The tangent of a path is `u_hat (|P'| - r . u_hat') + (r / R) R'`, if the frame does not rotate about it.
    fn only_leaves_through(&self, tube: &Tube<f64>, side: &OpenSide, scene_origin: DVec3) -> bool {
        let in_scene = |corner: DVec3| tube.placement.world_from_tube(corner) - scene_origin;
        let highest = self.curve.bounds.corners().map(|corner| side.height(in_scene(corner)));
        if highest.into_iter().fold(f64::NEG_INFINITY, f64::max) < -ROUNDING * (1.0 + side.offset.abs()) {
            return true;
        }
        let outward = tube.placement.rotation.transpose() * side.normal;
        let (cos, sin) = self.turn;
        let angle = libm::acos(outward.dot(self.curve.u_hat(0.5)).clamp(-1.0, 1.0)) + libm::acos(cos);
        let (d, a) = self.in_plane[0];
        let slowest = d.min(d + a);
        if tube.frame == FrameMode::Up || angle >= std::f64::consts::FRAC_PI_2 || slowest <= 0.0 {
            return false;
        }
        let turning = (self.in_plane[1].1.abs() + a.abs() * sin) / slowest;
        let speed = 2.0 * slowest - self.radius([0.0, 1.0])[1] * turning;
        // Points that reach the side are offset towards it from a curve that is inside, and a widening tube carries
        // them on outwards.
        let Curve { b0, d0, b2, .. } = self.curve;
        let curve_is_inside = [b0, b0 + d0, b2].iter().all(|&point| side.height(in_scene(point)) < 0.0);
        let inwards = |radius_derivative: f64| {
            if curve_is_inside { (-radius_derivative).max(0.0) } else { radius_derivative.abs() }
        };
        let spread = [0.0, 1.0].map(|u| inwards(self.curve.radius_derivative(u)));
        speed * libm::cos(angle) > spread[0].max(spread[1]) * libm::sin(angle)
    }

    fn radius(&self, u: Range) -> Range {
        let Curve { r0, e0, ar, .. } = self.curve;
        let slack = ROUNDING * (r0.abs() + e0.abs());
        let [low, high] = quadratic_on(r0, (e0, ar), u);
        [(low - slack).max(0.0), (high + slack).max(0.0)]
    }

    /// Returns the parameter, from 0 to 1, at which the curve has advanced by `along` in the direction of the middle
    /// tangent.
    fn parameter(&self, along: f64) -> f64 {
        let (d, a) = self.in_plane[0];
        let root = d * d + a * along;
        if along <= 0.0 {
            0.0
        } else if root < 0.0 || d + root.sqrt() <= 0.0 {
            1.0
        } else {
            (along / (d + root.sqrt())).min(1.0)
        }
    }
}

/// Returns the least absolute value in a range.
fn distance([low, high]: Range) -> f64 {
    low.max(-high).max(0.0)
}

/// Returns the range of `p + u (2 d + u a)` over a range of u.
fn quadratic_on(p: f64, (d, a): (f64, f64), [start, end]: Range) -> Range {
    let h = end - start;
    let (low, high) = quadratic_range(p + start * (2.0 * d + start * a), (d + start * a) * h, a * h * h);
    [low, high]
}

/// Returns the range of `a x + b y`.
fn linear_range([x_low, x_high]: Range, a: f64, [y_low, y_high]: Range, b: f64) -> Range {
    let (ax, ay) = ([a * x_low, a * x_high], [b * y_low, b * y_high]);
    [ax[0].min(ax[1]) + ay[0].min(ay[1]), ax[0].max(ax[1]) + ay[0].max(ay[1])]
}

/// Returns the ranges of a vector's components after a rotation of at most `angle` radians either way.
fn turned(v: Range, w: Range, angle: f64) -> (Range, Range) {
    if angle == 0.0 {
        return (v, w);
    }
    let size = |[low, high]: Range| low.abs().max(high.abs());
    // A component changes by at most the length of the vector's change.
    let length = libm::hypot(size(v), size(w));
    let by = length * angle.min(2.0);
    let moved = |[low, high]: Range| [low - by, high + by];
    (moved(v), moved(w))
}

/// Returns the part of a range that is within `most` of 0.
fn within([low, high]: Range, most: f64) -> Range {
    [low.max(-most), high.min(most)]
}

#[cfg(test)]
mod tests;

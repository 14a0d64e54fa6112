//! Slabs of the tube for the mapping passes: the curve, bounding planes, and bounds for edges that are surely straight.

use glam::{DVec2, DVec3, DVec4, Vec3};
use light::{Curve, Tube};
use relight::MapSlab;

use super::map_shape::MapShape;
use crate::settings::ShadowSettings;

/// Overlap with adjacent slabs, as a share of a slab. It exceeds rounding, 1e-6. It is small because past a joint the
/// curve belongs to another segment: there the error of t is up to the square of the overlap.
const OVERLAP: f64 = 5e-4;
/// Factor for the bend, which is sampled on a grid over the slab, between the samples.
const SAMPLING_MARGIN: f64 = 2.0;
/// Largest slope of the logarithm of u's change along an edge that counts as straight. The error at the edge's middle
/// is then at most 1.09 times that for uniform u. The worst case is `exp(-MAX_LOG_SLOPE |s - 1/2|)`: the mean of its
/// square, weighted by a tent as deviations of the middle are, over the square of its mean.
const MAX_LOG_SLOPE: f64 = 0.5;
/// Bounds under which no edge counts as straight: larger than 1 and than any radius. WGSL has no infinity.
const NEVER_SAFE: [f32; 4] = [1e30; 4];

/// Slab of a tube, with the corners of its box in tube space.
pub struct BoxedSlab {
    pub slab: MapSlab,
    pub corners: [DVec3; 8],
}

/// Returns the slabs of the part of a tube that a map shows.
pub fn slabs_of_map(tube: &Tube<f64>, map: &MapShape, shadows: &ShadowSettings) -> Vec<BoxedSlab> {
    // The tube is 2 wide in v and w.
    let resolution = 2.0 * map.texels_per_vw();
    let tolerance = f64::from(shadows.split_above_texels()) / resolution;
    map.t_range().map_or_else(Vec::new, |t_range| slabs(tube, map.t_base(), t_range, tolerance))
}

/// Returns the bounds of slabs in tube space.
pub fn slab_bounds(slabs: &[BoxedSlab]) -> [Vec3; 2] {
    let corners = || slabs.iter().flat_map(|boxed| boxed.corners);
    let (low, high) = (corners().fold(DVec3::INFINITY, DVec3::min), corners().fold(DVec3::NEG_INFINITY, DVec3::max));
    [low.as_vec3(), high.as_vec3()]
}

/// Returns the slabs of `tube` from t = `first` to `last`. Their t is relative to `t_base`. `tolerance` is the permitted
/// deviation of an edge's image, as a share of the map's width.
pub fn slabs(tube: &Tube<f64>, t_base: f64, [first, last]: [f64; 2], tolerance: f64) -> Vec<BoxedSlab> {
    light::slabs(tube, last, OVERLAP)
        .iter()
        .filter_map(|slab| {
            let share = |t: f64| ((t - slab.t_start) / slab.t_span).clamp(0.0, 1.0);
            let (start, end) = (share(first), share(last));
            if start >= end {
                return None;
            }
            let piece = slab.slab_curve.subcurve(start, end);
            let (t_start, t_span) = (slab.t_start + slab.t_span * start, slab.t_span * (end - start));
            let slab = MapSlab {
                curve: piece.to_f32(),
                t_start: (t_start - t_base) as f32,
                t_span: t_span as f32,
                planes: planes(&piece),
                edge_bounds: edge_bounds(tube, &piece, t_span, tolerance),
            };
            Some(BoxedSlab { slab, corners: piece.bounds.corners() })
        })
        .collect()
}

/// Returns planes `(n, w)`, in which `n.q + w` is the distance of `q` from the plane, positive inside: the planes
/// perpendicular to the curve at both ends, then the sides of the box.
fn planes(piece: &Curve<f64>) -> [[f32; 4]; 6] {
    let through = |point: DVec3, inward: DVec3| inward.extend(-inward.dot(point)).as_vec4().to_array();
    let b = &piece.bounds;
    let side = |axis: usize, sign: f64| through(b.center + b.axes[axis] * (sign * b.half[axis]), b.axes[axis] * -sign);
    [
        through(piece.b0, piece.u_hat(0.0)),
        through(piece.b2, -piece.u_hat(1.0)),
        side(1, 1.0),
        side(1, -1.0),
        side(2, 1.0),
        side(2, -1.0),
    ]
}

/// Bounds for an edge whose image is surely straight. With `[p, q, r, s]`, an edge of length `e` between parameters
/// that differ by `dt` is straight if `(p dt + q e) dt` is at most the smaller radius of its ends, and `r dt + s e` is
/// at most 1. The image may deviate by `tolerance` times the map's resolution in texels.
///
/// Light model, section 4, with `e_u = sigma u'`, where `u'` is the derivative of u along the edge. The ends give its
/// mean, because u is monotone along a straight edge. It is nearly uniform, because the second pair bounds `|u''/u'|`
/// by [`MAX_LOG_SLOPE`]. `E = (resolution / 16 R) |(H_V - v H_R, H_W - w H_R)|`, and `|H_t| sigma` along the light,
/// with each second derivative at its largest over the slab and over the edge's directions. An edge perpendicular to
/// the light is straight, however long. No edge counts as straight where the map is close to folding, or in the "up"
/// frame, whose twist the formulas leave out.
fn edge_bounds(tube: &Tube<f64>, piece: &Curve<f64>, t_span: f64, tolerance: f64) -> [f32; 4] {
    if tube.frame == light::FrameMode::Up {
        return NEVER_SAFE;
    }
    // The corner of the slab's box is at v = w = 1.
    let rim = std::f64::consts::SQRT_2;
    let mut worst = DVec4::ZERO;
    for step in 0..=4 {
        let u = f64::from(step) / 4.0;
        let (u_hat, d, radius) = (piece.u_hat(u), piece.d(u), piece.radius(u));
        let turn = piece.u_hat_derivative(u, u_hat).length();
        let speed = 2.0 * d.length();
        // The offset with the largest bend leans into the turn; the change of speed counts for every offset.
        for lean in [-rim, 0.0, rim] {
            let r_turn = lean * radius * turn;
            let sigma = speed - r_turn;
            if sigma <= 0.05 * speed {
                return NEVER_SAFE;
            }
            let pull = (2.0 * piece.a.dot(u_hat) * (1.0 + r_turn / d.length())).abs();
            // Coefficients of u'^2 and of u' e.
            let h_t = DVec2::new(pull, 2.0 * turn) / sigma;
            let h_r = DVec2::new((2.0 * piece.ar).abs(), 0.0) + piece.radius_derivative(u).abs() * h_t;
            let across = DVec2::new(turn * sigma, 0.0) + rim * h_r;
            let deviation = across.max(h_t * sigma) / (16.0 * tolerance);
            let uneven = h_t / MAX_LOG_SLOPE;
            worst = worst.max(DVec4::new(deviation.x, deviation.y, uneven.x, uneven.y));
        }
    }
    let of_t = DVec4::new(1.0 / (t_span * t_span), 1.0 / t_span, 1.0 / t_span, 1.0);
    (worst * of_t * SAMPLING_MARGIN).min(DVec4::splat(1e30)).as_vec4().to_array()
}

#[cfg(test)]
mod tests;

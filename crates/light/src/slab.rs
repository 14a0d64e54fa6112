//! Slabs: pieces of a tube, cut across, that turn little. Shadow maps and bent rays map surfaces into them.

use crate::{Curve, EndMode, Tube, TubeBox};

/// Piece of one segment.
#[derive(Clone, Copy, Debug)]
pub struct TubeSlab {
    /// Curve of the piece, whose parameter runs from 0 to 1.
    pub slab_curve: Curve<f64>,
    /// Global t at the start of the piece.
    pub t_start: f64,
    /// Global t per unit of the piece's parameter.
    pub t_span: f64,
}

/// Cosine of the largest turn of the tangent in a slab. With it, a point of the slab lies between the slab's two end
/// planes.
const MAX_TURN_COS: f64 = 0.965_925_826_289_068_3;
/// Largest ratio of the curve's speeds `|P'|` at the two ends of a slab. Below it, equal steps of the parameter are
/// nearly equal lengths of the curve.
const MAX_SPEED_RATIO: f64 = 1.4;
/// Maximum number of halvings of a segment, for `2^MAX_HALVINGS` slabs. Only a cusp needs so many.
const MAX_HALVINGS: usize = 6;
/// Maximum number of further halvings of a slab whose box comes too near to the evolute. The box extends past the rim
/// by `1 - cos` of half the slab's turn, in radii of the bend, so each halving reduces this excess to a quarter.
const MAX_TIGHT_HALVINGS: usize = 4;
/// Maximum share of the distance from the rim to the evolute that the box may take.
const MAX_EVOLUTE_SHARE: f64 = 0.75;
/// Number of intervals of a slab at whose ends the evolute is tested.
const EVOLUTE_SAMPLES: u32 = 4;

/// Cuts a light's tube into slabs in ascending t. An extended light is cut at `t_max`; for others that has no effect.
///
/// Adjacent slabs overlap by `overlap` in their own parameter, so that surfaces mapped slab by slab have no seams.
pub fn slabs(tube: &Tube<f64>, t_max: f64, overlap: f64) -> Vec<TubeSlab> {
    let mut slabs = Vec::new();
    for (i, segment) in tube.segments.iter().enumerate() {
        let curve = &segment.curve;
        let end = if i < tube.n { 1.0 } else { t_max - tube.n as f64 };
        if end > 0.0 {
            split_range(curve, [0.0, end], MAX_HALVINGS + MAX_TIGHT_HALVINGS, &mut |start, end| {
                let is_first = i == 0 && start == 0.0;
                let is_last = tube.end_mode() == EndMode::Cut && i + 1 == tube.n && end == 1.0;
                let margin = overlap * (end - start);
                // Past a cusp, where control points coincide, the polynomial runs back. There slabs do not overlap.
                let runs_on = |u: f64| curve.d(u).dot(curve.d(f64::midpoint(start, end))) > 0.0;
                let start = if is_first || !runs_on(start - margin) { start } else { start - margin };
                let end = if is_last || !runs_on(end + margin) { end } else { end + margin };
                let piece = curve.subcurve(start, end);
                slabs.push(TubeSlab { slab_curve: piece, t_start: i as f64 + start, t_span: end - start });
            });
        }
    }
    slabs
}

/// Halves a range of a segment until it turns little, has nearly even speed, and has a box in which each point has one
/// nearest point of the curve.
fn split_range(curve: &Curve<f64>, [start, end]: [f64; 2], depth: usize, emit: &mut impl FnMut(f64, f64)) {
    let (d0, d1) = (curve.d(start), curve.d(end));
    let (slow, fast) = (d0.length().min(d1.length()), d0.length().max(d1.length()));
    let turns = curve.u_hat(start).dot(curve.u_hat(end)) < MAX_TURN_COS;
    let is_uneven = depth > MAX_TIGHT_HALVINGS && (turns || fast > MAX_SPEED_RATIO * slow);
    if depth > 0 && (is_uneven || !turns && reaches_evolute(&curve.subcurve(start, end))) {
        let middle = f64::midpoint(start, end);
        split_range(curve, [start, middle], depth - 1, emit);
        split_range(curve, [middle, end], depth - 1, emit);
    } else {
        emit(start, end);
    }
}

/// Returns true if the box of a piece extends past the rim of the tube towards the centre of the bend, by more than
/// [`MAX_EVOLUTE_SHARE`] of the distance to the evolute. Past the evolute points are nearest to another part of the
/// curve.
fn reaches_evolute(piece: &Curve<f64>) -> bool {
    let TubeBox { center, axes, half } = &piece.bounds;
    (0..=EVOLUTE_SAMPLES).any(|k| {
        let u = f64::from(k) / f64::from(EVOLUTE_SAMPLES);
        let u_hat = piece.u_hat(u);
        // kappa N, towards the centre of the bend.
        let bend = piece.u_hat_derivative(u, u_hat) / (2.0 * piece.d(u).length());
        let inward = bend.dot(axes[1]);
        let side = center.dot(axes[1]) + half[1].copysign(inward) - piece.position(u).dot(axes[1]);
        // The side of the box lies `side / (N . axis)` along N.
        let r_kappa = piece.radius(u).max(0.0) * bend.length();
        inward != 0.0 && side * bend.length_squared() / inward > r_kappa + MAX_EVOLUTE_SHARE * (1.0 - r_kappa)
    })
}

//! The tube cut across into pieces that turn little, for whoever maps surfaces into it (shadow maps, bent
//! rays).

use crate::{Curve, EndMode, Tube, TubeBox};

/// A piece of one segment.
#[derive(Clone, Copy, Debug)]
pub struct TubeSlab {
    /// Its curve, whose parameter runs from 0 to 1.
    pub slab_curve: Curve<f64>,
    /// Global t where the piece starts.
    pub t_start: f64,
    /// Global t per unit of the piece's parameter.
    pub t_span: f64,
}

/// Largest turn of the tangent in a slab. With it, a point of the tube's slab lies between the slab's two end
/// planes.
const MAX_TURN_COS: f64 = 0.965_925_826_289_068_3;
/// Largest ratio of the speeds at a slab's ends: the parameter is then nearly even over the slab.
const MAX_SPEED_RATIO: f64 = 1.4;
/// Slabs of one segment, at most `2^MAX_HALVINGS`; only a cusp asks for more.
const MAX_HALVINGS: usize = 6;
/// Halvings of a slab beyond those, so that its box stays this side of the evolute: half the turn adds `1 - cos` of it to
/// `R kappa`, a quarter as much each time.
const MAX_TIGHT_HALVINGS: usize = 4;
/// Of what is left between the rim and the evolute, the box may have this share.
const MAX_EVOLUTE_SHARE: f64 = 0.75;
/// Places of a slab where the evolute is looked for.
const EVOLUTE_SAMPLES: u32 = 4;

/// Cuts a light's tube into slabs in ascending t. An extended light is cut at `t_max`; otherwise that has no
/// effect.
///
/// Neighbours overlap by `overlap` in their own parameter, so that what is mapped piece by piece has no seams.
pub fn slabs(tube: &Tube<f64>, t_max: f64, overlap: f64) -> Vec<TubeSlab> {
    let mut out = Vec::new();
    for (i, segment) in tube.segments.iter().enumerate() {
        let curve = &segment.curve;
        let end = if i < tube.n { 1.0 } else { t_max - tube.n as f64 };
        if end > 0.0 {
            split_range(curve, (0.0, end), MAX_HALVINGS + MAX_TIGHT_HALVINGS, &mut |start, end| {
                let (first, last) = (
                    i == 0 && start == 0.0,
                    tube.end_mode() == EndMode::Cut && i + 1 == tube.n && end == 1.0,
                );
                let margin = overlap * (end - start);
                // Past a cusp, where control points coincide, the polynomial runs back: there slabs only meet.
                let runs_on = |u: f64| curve.d(u).dot(curve.d(f64::midpoint(start, end))) > 0.0;
                let start = if first || !runs_on(start - margin) { start } else { start - margin };
                let end = if last || !runs_on(end + margin) { end } else { end + margin };
                let piece = curve.subcurve(start, end);
                out.push(TubeSlab { slab_curve: piece, t_start: i as f64 + start, t_span: end - start });
            });
        }
    }
    out
}

/// Halves a range of a segment until it turns little, runs evenly, and has a box within which each point is nearest to the curve
/// in one place.
fn split_range(curve: &Curve<f64>, range: (f64, f64), depth: usize, emit: &mut impl FnMut(f64, f64)) {
    let (start, end) = range;
    let (d0, d1) = (curve.d(start), curve.d(end));
    let (slow, fast) = (d0.length().min(d1.length()), d0.length().max(d1.length()));
    let turns = curve.u_hat(start).dot(curve.u_hat(end)) < MAX_TURN_COS;
    let is_uneven = depth > MAX_TIGHT_HALVINGS && (turns || fast > MAX_SPEED_RATIO * slow);
    if depth > 0 && (is_uneven || !turns && reaches_evolute(&curve.subcurve(start, end))) {
        let middle = f64::midpoint(start, end);
        split_range(curve, (start, middle), depth - 1, emit);
        split_range(curve, (middle, end), depth - 1, emit);
    } else {
        emit(start, end);
    }
}

/// Whether the box of a piece reaches farther into its bend than the tube, by more than [`MAX_EVOLUTE_SHARE`] of the way to the evolute:
/// past that, points are nearest to the curve elsewhere.
fn reaches_evolute(piece: &Curve<f64>) -> bool {
    let TubeBox { center, axes, half } = &piece.bounds;
    let places = (0..=EVOLUTE_SAMPLES).map(|k| f64::from(k) / f64::from(EVOLUTE_SAMPLES));
    places.into_iter().any(|u| {
        let u_hat = piece.u_hat(u);
        // kappa N, towards the centre of the bend.
        let bend = piece.u_hat_derivative(u, u_hat) / (2.0 * piece.d(u).length());
        let inward = bend.dot(axes[1]);
        let side = center.dot(axes[1]) + half[1].copysign(inward) - piece.position(u).dot(axes[1]);
        // The box's side lies `side / (N . axis)` along N.
        let r_kappa = piece.radius(u).max(0.0) * bend.length();
        inward != 0.0 && side * bend.length_squared() / inward > r_kappa + MAX_EVOLUTE_SHARE * (1.0 - r_kappa)
    })
}

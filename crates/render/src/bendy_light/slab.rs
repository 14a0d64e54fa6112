//! Slabs of the tube as the mapping passes want them: curve, planes around, and how long an edge is surely
//! straight.

use glam::DVec3;
use light::{Curve, Tube};

use super::gpu_curve;
use super::gpu_structs::Slab;

/// How many fit into one uniform; `bent_map.wgsl` has the same number. A light with more is mapped in turns.
pub(crate) const SLABS_A_TURN: usize = 240;
/// Share of a slab by which it overlaps its neighbours. More than rounding, 1e-6; and little, because past a
/// joint the curve is not this segment's: there t is off by up to the square of it.
const OVERLAP: f64 = 5e-4;
/// The bend is sampled on a grid over the slab; between samples it may be this much larger.
const SAMPLING_MARGIN: f64 = 2.0;

/// The slabs of `tube` from t = `first` to `last`, each with the corners of its box in tube space. Their t is counted
/// from `t_base`.
pub(crate) fn slabs(
    tube: &Tube<f64>,
    (t_base, [first, last]): (f64, [f64; 2]),
    resolution: f64,
    tolerance_texels: f64,
) -> Vec<(Slab, [DVec3; 8])> {
    light::slabs(tube, last, OVERLAP)
        .iter()
        .filter_map(|slab| {
            let share = |t: f64| ((t - slab.t_start) / slab.t_span).clamp(0.0, 1.0);
            let (start, end) = (share(first), share(last));
            if start >= end {
                return None;
            }
            let piece = slab.piece.piece(start, end);
            let (t_start, t_span) = (slab.t_start + slab.t_span * start, slab.t_span * (end - start));
            let bend = bend_a_texel2(tube, &piece, resolution);
            let gpu = Slab {
                curve: gpu_curve(&piece.to_f32(), t_start - t_base, t_span),
                planes: planes(&piece),
                safe_texels: (tolerance_texels / bend).sqrt().min(1e6) as f32,
                pad0: [0.0; 3],
            };
            Some((gpu, piece.bounds.corners()))
        })
        .collect()
}

/// `(n, w)` with `n.q + w` the distance inside: the planes square to the curve at both ends, then the sides
/// of the box.
fn planes(piece: &Curve<f64>) -> [[f32; 4]; 6] {
    let through = |point: DVec3, inward: DVec3| inward.extend(-inward.dot(point)).as_vec4().to_array();
    let b = &piece.bounds;
    let side = |axis: usize, sign: f64| {
        through(b.center + b.axes[axis] * (sign * b.half[axis]), b.axes[axis] * -sign)
    };
    [
        through(piece.b0, piece.u_hat(0.0)),
        through(piece.b2, -piece.u_hat(1.0)),
        side(1, 1.0),
        side(1, -1.0),
        side(2, 1.0),
        side(2, -1.0),
    ]
}

/// Largest error, in texels, of the straight image of an edge one texel long: it grows with the square of the
/// length.
///
/// Light model, section 4: `E = (resolution / 16 R) |(H_V - v H_R, H_W - w H_R)|`, and along the light
/// `(resolution / 16 R) |H_t| sigma`, with each second derivative at its largest over the edge's directions.
/// `|e| = 2 R / resolution` is one texel. Infinite where the map is close to folding, and in the "up" frame,
/// whose twist the formulas leave out.
fn bend_a_texel2(tube: &Tube<f64>, piece: &Curve<f64>, resolution: f64) -> f64 {
    if tube.frame == light::Frame::Up {
        return f64::INFINITY;
    }
    // The corner of the slab's box lies at v = w = 1.
    let rim = std::f64::consts::SQRT_2;
    let mut worst = 0.0_f64;
    for step in 0..=4 {
        let u = f64::from(step) / 4.0;
        let (u_hat, d, radius) = (piece.u_hat(u), piece.d(u), piece.radius(u));
        let turn = piece.u_hat_derivative(u, u_hat);
        let speed = 2.0 * d.length();
        // The offset that bends most leans into the turn; the speed's change counts for every offset.
        for lean in [-rim, 0.0, rim] {
            let r_turn = lean * radius * turn.length();
            let sigma = speed - r_turn;
            if sigma <= 0.05 * speed {
                return f64::INFINITY;
            }
            let pull = 2.0 * piece.a.dot(u_hat) * (1.0 + r_turn / d.length());
            let h_t = 2.0 * turn.length() / (sigma * sigma) + pull.abs() / (sigma * sigma * sigma);
            let h_r = (2.0 * piece.ar).abs() / (sigma * sigma) + piece.radius_derivative(u).abs() * h_t;
            let across = turn.length() / sigma + rim * h_r;
            worst = worst.max(radius / (4.0 * resolution) * across.max(h_t * sigma));
        }
    }
    SAMPLING_MARGIN * worst.max(1e-300)
}

//! Coordinates of a point in or near a tube. The slow solver uses them until the point is in the tube and the light's
//! `locate` applies.

use glam::{DVec2, DVec3};
use light::{Tube, TubeRoot};

/// Number of pieces of a segment in which the nearest curve parameter is searched.
const PIECES: usize = 8;

/// Number of bisections of a piece: to a share of 1e-13 of a segment.
const BISECTIONS: usize = 40;

/// Length in segments to which the last segment of a light with an extended end is followed.
const MAX_EXTENSION_SEGMENTS: f64 = 64.0;

/// Coordinates of a point in or near a tube.
#[derive(Clone, Copy, Debug)]
pub struct NearestCoords {
    pub t: f64,
    /// (v, w) in radii.
    pub across: DVec2,
    /// Unit vector in world space towards the light's origin along its path.
    pub direction: DVec3,
    /// `1 - kappa r.N`.
    pub fold_factor: f64,
    /// Distance past the source or the end, in radii.
    pub beyond: f64,
}

/// Finds the coordinates with the smallest `|r| / R` among all parameters at which the curve is perpendicular to the
/// direction of the point, at any distance from the curve, and among the ends.
pub fn nearest_coords(tube: &Tube<f64>, point_in_world: DVec3) -> Option<NearestCoords> {
    let q = tube.placement.tube_from_world(point_in_world);
    let mut best: Option<NearestCoords> = None;
    let mut offer = |segment: usize, u: f64| {
        let curve = &tube.segments[segment].curve;
        let (r, radius, u_hat) = (curve.offset(q, u), curve.radius(u), curve.u_hat(u));
        if radius <= 0.0 {
            return;
        }
        let (v_hat, w_hat) = tube.cross_section(curve, u_hat);
        let (v_len, w_len) = (r.dot(v_hat), r.dot(w_hat));
        let root = TubeRoot { segment, u, r, v_len, w_len, radius, v_hat, u_hat };
        let turn = curve.u_hat_derivative(u, u_hat);
        let coords = NearestCoords {
            t: root.t(),
            across: DVec2::new(v_len, w_len) / radius,
            direction: tube.placement.rotation * tube.direction_at(&root),
            fold_factor: 1.0 - r.dot(turn) / (2.0 * curve.d(u).length()),
            beyond: r.dot(u_hat).abs() / radius,
        };
        let out = |coords: &NearestCoords| coords.across.length() + 10.0 * coords.beyond;
        if best.as_ref().is_none_or(|best| out(&coords) < out(best)) {
            best = Some(coords);
        }
    };
    for (segment, of) in tube.segments.iter().enumerate() {
        // Positive before the foot point, negative past it.
        let ahead = |u: f64| of.curve.offset(q, u).dot(of.curve.d(u));
        let end = if segment == tube.n { MAX_EXTENSION_SEGMENTS } else { 1.0 };
        for piece in 0..PIECES {
            let [mut low, mut high] = [piece, piece + 1].map(|k| end * k as f64 / PIECES as f64);
            if ahead(low) < 0.0 || ahead(high) >= 0.0 {
                continue;
            }
            for _ in 0..BISECTIONS {
                let middle = f64::midpoint(low, high);
                if ahead(middle) >= 0.0 { low = middle } else { high = middle }
            }
            offer(segment, f64::midpoint(low, high));
        }
    }
    offer(0, 0.0);
    if tube.segments.len() == tube.n {
        offer(tube.n - 1, 1.0);
    }
    best
}

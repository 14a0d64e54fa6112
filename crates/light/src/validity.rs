//! Folds of a tube: the largest `R kappa` of a curve.

use crate::Curve;

/// Returns the largest value of `R(u) kappa(u)` over `[0, 1]`. The tube is an embedding near its curve if this is below
/// 1.
///
/// `kappa = |d0 x d1| / (2 |d|^3)`. Candidates are the ends and the roots of `R' g - 1.5 R g'` with `g = |d|^2` (light
/// model, section 3), a cubic. Its roots are isolated between the zeros of its derivative and bisected to rounding
/// level. `R kappa` is flat at its maximum, so this costs no accuracy. The result is infinite if the speed of a bent
/// tube vanishes.
pub fn r_kappa_max(curve: &Curve<f64>) -> f64 {
    let cross = curve.d0.cross(curve.d1).length();
    if cross <= 1e-15 * curve.d0.length() * curve.d1.length() {
        return 0.0;
    }
    let g = [curve.d0.dot(curve.d0), 2.0 * curve.d0.dot(curve.a), curve.a.dot(curve.a)];
    let r = [curve.r0, 2.0 * curve.e0, curve.ar];
    // Coefficients, ascending, of R' g - 1.5 R g'.
    let cubic = [
        r[1] * g[0] - 1.5 * r[0] * g[1],
        r[1] * g[1] + 2.0 * r[2] * g[0] - 1.5 * (2.0 * r[0] * g[2] + r[1] * g[1]),
        r[1] * g[2] + 2.0 * r[2] * g[1] - 1.5 * (2.0 * r[1] * g[2] + r[2] * g[1]),
        2.0 * r[2] * g[2] - 1.5 * 2.0 * r[2] * g[2],
    ];
    let r_kappa = |u: f64| {
        let speed = curve.d(u).length();
        curve.radius(u).max(0.0) * cross / (2.0 * speed * speed * speed)
    };
    let candidates = roots_in_unit_interval(&cubic);
    candidates.into_iter().chain([0.0, 1.0]).map(r_kappa).fold(0.0, f64::max)
}

/// Returns the roots in `[0, 1]` of the cubic with these ascending coefficients, by bisection between the zeros of its
/// derivative.
fn roots_in_unit_interval(c: &[f64; 4]) -> Vec<f64> {
    let value = |u: f64| ((c[3] * u + c[2]) * u + c[1]) * u + c[0];
    let mut knots = vec![0.0];
    // 3 c3 u^2 + 2 c2 u + c1 = 0, in the form that does not cancel.
    let discriminant = c[2] * c[2] - 3.0 * c[3] * c[1];
    if discriminant > 0.0 {
        let q = -(c[2] + discriminant.sqrt().copysign(c[2]));
        let mut turns = [q / (3.0 * c[3]), c[1] / q];
        turns.sort_by(f64::total_cmp);
        knots.extend(turns.into_iter().filter(|u| (0.0..=1.0).contains(u)));
    }
    knots.push(1.0);
    knots
        .windows(2)
        .filter(|k| (value(k[0]) <= 0.0) != (value(k[1]) <= 0.0))
        .map(|k| {
            let (mut low, mut high) = (k[0], k[1]);
            // The lower end keeps this sign as it moves.
            let below = value(low) <= 0.0;
            for _ in 0..60 {
                let middle = f64::midpoint(low, high);
                if below == (value(middle) <= 0.0) { low = middle } else { high = middle }
            }
            f64::midpoint(low, high)
        })
        .collect()
}

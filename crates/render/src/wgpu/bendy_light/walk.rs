//! Reference of the shadow tests: traces the bent path in f64 against every triangle. Slow, and shares nothing with the
//! GPU's passes.

use glam::DVec3;
use light::Tube;

/// Number of straight steps of the polyline that approximates a path. The error of a chord on a path of curvature k is
/// `k (length / steps)^2 / 8`: 1e-7 of the light's length here.
const STEPS: usize = 1500;

/// Returns the tube-space point at `(t, v, w)`: `P + R (v v_hat + w w_hat)`.
pub fn point_at(tube: &Tube<f64>, t: f64, v: f64, w: f64) -> DVec3 {
    let i = (t as usize).min(tube.n - 1);
    let (segment, u) = (&tube.segments[i].curve, t - i as f64);
    let (v_hat, w_hat) = tube.cross_section(segment, segment.u_hat(u));
    segment.position(u) + (v_hat * v + w_hat * w) * segment.radius(u)
}

/// Returns the parameter, from 0 to 1, of the intersection of the segment from `a` to `b` with the triangle.
fn hit(a: DVec3, b: DVec3, [p, q, r]: [DVec3; 3]) -> Option<f64> {
    let (direction, e1, e2) = (b - a, q - p, r - p);
    let normal = e1.cross(e2);
    let closing = normal.dot(direction);
    if closing == 0.0 {
        return None;
    }
    let share = normal.dot(p - a) / closing;
    if !(0.0..=1.0).contains(&share) {
        return None;
    }
    let at = a + direction * share - p;
    let area = normal.length_squared();
    let (beta, gamma) = (at.cross(e2).dot(normal) / area, e1.cross(at).dot(normal) / area);
    (beta >= 0.0 && gamma >= 0.0 && beta + gamma <= 1.0).then_some(share)
}

/// True if light on the path (v, w) arrives at `t` without meeting one of the triangles, which are in tube space and do
/// not include the receiver.
pub fn reaches(tube: &Tube<f64>, triangles: &[[DVec3; 3]], t: f64, v: f64, w: f64) -> bool {
    let mut before = point_at(tube, 0.0, v, w);
    (1..=STEPS).all(|k| {
        let here = point_at(tube, t * k as f64 / STEPS as f64, v, w);
        let blocked = triangles.iter().any(|&triangle| hit(before, here, triangle).is_some());
        before = here;
        !blocked
    })
}

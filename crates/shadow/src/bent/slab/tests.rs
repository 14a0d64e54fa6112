//! Tests that edges which count as straight are straight, and that most straight edges count as such.

use glam::{DVec2, DVec3, DVec4};
use light::{Curve, Light, Tube, increasing_roots};

use super::{NEVER_SAFE, OVERLAP, edge_bounds};

/// Returns a light that turns by 70 degrees and slightly back: three strongly bent segments.
fn light() -> Light {
    let points = [(0., 0., 0.), (0.3, 0.1, -1.2), (-0.2, 0.4, -2.6), (1.9, -0.2, -3.3), (3.1, 0.3, -4.6)];
    Light::bendy(points.map(DVec3::from).to_vec(), vec![0.15, 0.35, 0.45, 0.5, 0.8])
}

const RESOLUTION: f64 = 2048.0;
const TOLERANCE_TEXELS: f64 = 0.25;

/// A point of the slab and its (V, W, R, u).
struct Mapped {
    q: DVec3,
    mapped: DVec4,
}

fn at(piece: &Curve<f64>, [u, v, w]: [f64; 3]) -> Mapped {
    let (v_hat, w_hat) = piece.rotation_minimizing(piece.u_hat(u));
    let vw = DVec2::new(v, w) * piece.radius(u);
    Mapped { q: piece.position(u) + v_hat * vw.x + w_hat * vw.y, mapped: vw.extend(piece.radius(u)).extend(u) }
}

fn map(piece: &Curve<f64>, q: DVec3) -> DVec4 {
    let f = [-(q - piece.b0).dot(piece.d0), -(q - piece.b2).dot(piece.d1)];
    let u = increasing_roots(piece, q, f[0].min(0.0), f[1].max(0.0)).found();
    let u = u.min_by(|a, b| piece.offset(q, *a).length().total_cmp(&piece.offset(q, *b).length()));
    let u = u.expect("inside the slab");
    let (v_hat, w_hat) = piece.rotation_minimizing(piece.u_hat(u));
    let r = piece.offset(q, u);
    DVec4::new(r.dot(v_hat), r.dot(w_hat), piece.radius(u), u)
}

/// Returns the largest deviation of an edge's image from the straight line drawn for it, in texels: across the map, and
/// along the light as a length in the scene.
fn strays(piece: &Curve<f64>, a: &Mapped, b: &Mapped) -> f64 {
    let at = |k: i32| {
        let share = f64::from(k) / 32.0;
        let (mapped, straight) = (map(piece, a.q.lerp(b.q, share)), a.mapped.lerp(b.mapped, share));
        let vw = |m: DVec4| DVec2::new(m.x, m.y) / m.z;
        let across = (vw(mapped) - vw(straight)).length();
        let along = (mapped.w - straight.w).abs() * 2.0 * piece.d(0.5).length() / straight.z;
        across.max(along) * RESOLUTION / 2.0
    };
    (1..32).map(at).fold(0.0, f64::max)
}

fn is_safe(bounds: [f64; 4], piece: &Curve<f64>, a: &Mapped, b: &Mapped) -> bool {
    let (du, length) = ((b.mapped.w - a.mapped.w).abs(), (b.q - a.q).length());
    let [p, q, r, s] = bounds;
    assert!(piece.radius(a.mapped.w) > 0.0);
    (p * du + q * length) * du <= a.mapped.z.min(b.mapped.z) && r * du + s * length <= 1.0
}

/// Returns the edges of all lengths and directions in all slabs of a light: the deviation of each, and true if bounds
/// scaled by `factor` call it straight.
fn edges(tube: &Tube<f64>, factor: f64) -> Vec<(f64, bool)> {
    let mut state = 1_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut found = Vec::new();
    for slab in light::slabs(tube, tube.n as f64, OVERLAP) {
        let bounds = edge_bounds(tube, &slab.slab_curve, 1.0, TOLERANCE_TEXELS / RESOLUTION);
        if bounds == NEVER_SAFE {
            continue;
        }
        let bounds = bounds.map(|bound| f64::from(bound) * factor);
        for _ in 0..400 {
            let a: [f64; 3] = [random(), 2.0 * random() - 1.0, 2.0 * random() - 1.0];
            // Extents along and across the light are independent, each from a thousandth to all of the slab.
            let [along, across] = [(); 2].map(|()| libm::pow(10.0, -3.0 * random()));
            let steps = [along, 2.0 * across, 2.0 * across].map(|step| step * (2.0 * random() - 1.0));
            let b = [0, 1, 2].map(|k| (a[k] + steps[k]).clamp(if k == 0 { 0.0 } else { -1.0 }, 1.0));
            let (a, b) = (at(&slab.slab_curve, a), at(&slab.slab_curve, b));
            found.push((strays(&slab.slab_curve, &a, &b), is_safe(bounds, &slab.slab_curve, &a, &b)));
        }
    }
    found
}

#[test]
fn edges_called_straight_are_straight() {
    let tube = Tube::new(&light()).expect("valid");
    let wrong =
        |edges: &[(f64, bool)]| edges.iter().filter(|(strays, safe)| *safe && *strays > TOLERANCE_TEXELS).count();
    let found = edges(&tube, 1.0);
    assert_eq!(wrong(&found), 0);
    // The bounds accept half of the edges that are straight by a factor of four.
    let straight = found.iter().filter(|edge| edge.0 < TOLERANCE_TEXELS / 4.0);
    let [all, safe] = straight.fold([0, 0], |[all, safe], edge| [all + 1, safe + usize::from(edge.1)]);
    assert!(all > 100 && 2 * safe > all, "{safe} of {all}");
    // The comparison detects bounds that are too small.
    assert!(wrong(&edges(&tube, 0.125)) > 0);
}

//! The oracle of shadows: a walk in f64 along the path of constant (v, w), over every triangle. Slow, and shares
//! nothing with the renderer.

use bendy::{EndMode, Root, Tube};
use glam::DVec3;

use super::place::{eps, point_at, point_in};

/// Steps of the polyline that stands for a path along a segment. A chord of a quadratic strays by `|a| / 4
/// STEPS^2`: 2e-5 of the segment's length at most.
const STEPS: usize = 160;
/// Texels of a shadow map along a side of the tube's square.
pub const RESOLUTION: u32 = 2048;
/// How far off a shadow's edge a point must lie to be compared, in texels.
const CLEARANCE: f64 = 2.0;

/// Cosine between normal and light below which a texel's width spans too much of the light.
const EDGE_ON: f64 = 0.1;

/// A surface's point, in tube space.
pub struct Receiver<'a> {
    pub root: &'a Root<f64>,
    /// Unit normal towards the viewer: light that arrives from behind does not reach this side.
    pub normal: DVec3,
}

/// Whether light reaches a point, or `None` where rounding or the map's texels may decide.
///
/// `triangles` are in tube space, `reach` is the size at which the renderer rounds their corners.
pub fn reaches(
    tube: &Tube<f64>,
    triangles: &[[DVec3; 3]],
    reach: f64,
    receiver: &Receiver,
    w_sign: f64,
) -> Option<bool> {
    let Receiver { root, normal } = receiver;
    let t = root.segment as f64 + root.u;
    let (v, w) = (root.v_len / root.radius, w_sign * root.w_len / root.radius);
    let texel = 2.0 / f64::from(RESOLUTION);
    let width = texel * root.radius;
    // The path's tangent by a difference, and the receiver's plane by it: how far t runs in a texel's width.
    let h = 1e-6;
    let tangent = (point_at(tube, t + h, v, w) - point_at(tube, t - h, v, w)) / (2.0 * h);
    let facing = -normal.dot(tangent) / tangent.length();
    if facing < -EDGE_ON {
        return Some(false);
    }
    if facing < EDGE_ON || 16.0 * eps::<f32>() * reach > 0.25 * width {
        return None;
    }
    let closing = facing * tangent.length();
    let per_texel =
        width / closing + width / tangent.length().min(2.0 * tube.segments[root.segment].d(root.u).length());
    let window = 3.0 * CLEARANCE * per_texel;
    let end = match tube.end_mode() {
        EndMode::Cut => tube.n as f64,
        EndMode::Extend => f64::INFINITY,
    };
    let own_plane = |[a, b, c]: [DVec3; 3]| {
        let across = (b - a).cross(c - a).normalize_or_zero();
        across.dot(root.r + tube.segments[root.segment].position(root.u) - a).abs() < 1e-5 * reach.max(1.0)
            && across.cross(*normal).length() < 1e-3
    };
    let own: Vec<bool> = triangles.iter().map(|&triangle| own_plane(triangle)).collect();
    let mut answer = None;
    for k in 0..9 {
        let [dv, dw] = [k % 3, k / 3].map(|step| (f64::from(step) - 1.0) * CLEARANCE * texel);
        let path = Path::new(tube, v + dv, w + dw, (t + window).min(end));
        if !path.clear_where_thin(triangles, reach) {
            return None;
        }
        let mut blocked = false;
        for (&triangle, &own) in triangles.iter().zip(&own) {
            for hit in path.hits(triangle) {
                if hit < t - window {
                    blocked = true;
                } else if !own {
                    return None;
                }
            }
        }
        if *answer.get_or_insert(!blocked) == blocked {
            return None;
        }
    }
    answer
}

/// A path as a polyline for each segment: at a corner, where control points coincide, it goes on elsewhere.
struct Path {
    /// t, position and radius of each vertex.
    pieces: Vec<Vec<(f64, DVec3, f64)>>,
}

impl Path {
    fn new(tube: &Tube<f64>, v: f64, w: f64, end: f64) -> Self {
        let piece = |i: usize| {
            let from = i as f64;
            let span = if i < tube.n { (end - from).min(1.0) } else { end - from };
            let vertex = move |step: usize| {
                let u = span * step as f64 / STEPS as f64;
                (from + u, point_in(tube, i, u, v, w), tube.segments[i].radius(u))
            };
            (0..=STEPS).map(vertex).collect()
        };
        Self { pieces: (0..tube.segments.len()).filter(|&i| end > i as f64).map(piece).collect() }
    }

    /// Whether no triangle is near where the tube is so thin that rounding moves it by texels.
    fn clear_where_thin(&self, triangles: &[[DVec3; 3]], reach: f64) -> bool {
        let thin = 64.0 * eps::<f32>() * reach * f64::from(RESOLUTION);
        let thin_part = || self.pieces.iter().flatten().filter(|(_, _, radius)| *radius < thin);
        triangles.iter().all(|&[a, b, c]| {
            let middle = (a + b + c) / 3.0;
            let size = [a, b, c].iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            thin_part().all(|&(_, p, _)| {
                normal.dot(p - a).abs() > 4.0 * thin || p.distance(middle) > size + 4.0 * thin
            })
        })
    }

    /// Every t at which the path meets the triangle.
    fn hits(&self, [a, b, c]: [DVec3; 3]) -> Vec<f64> {
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let area2 = normal.length_squared();
        if area2 == 0.0 {
            return vec![];
        }
        let side = |p: DVec3| normal.dot(p - a);
        let mut out = Vec::new();
        for pair in self.pieces.iter().flat_map(|piece| piece.windows(2)) {
            let [(t0, p0, _), (t1, p1, _)] = [pair[0], pair[1]];
            let (s0, s1) = (side(p0), side(p1));
            if (s0 < 0.0) == (s1 < 0.0) {
                continue;
            }
            let share = s0 / (s0 - s1);
            let at = p0 + (p1 - p0) * share - a;
            let (beta, gamma) = (at.cross(e2).dot(normal) / area2, e1.cross(at).dot(normal) / area2);
            if beta >= 0.0 && gamma >= 0.0 && beta + gamma <= 1.0 {
                out.push(t0 + (t1 - t0) * share);
            }
        }
        out
    }
}

//! Independent test of shadows: a walk in f64 along the light path of constant (v, w), over every triangle. It is slow,
//! and shares nothing with the renderer.

use glam::DVec3;
use light::{EndMode, Tube, TubeRoot};

use super::place::{eps, point_at, point_in};

/// Number of steps of the polyline that approximates a light path along one segment. A chord of a quadratic deviates by
/// `|a| / 4 STEPS^2`: at most 2e-5 of the segment's length.
const STEPS: usize = 160;
/// Texels of a shadow map per side of the tube's square.
pub const RESOLUTION: u32 = 2048;
/// Width of a texel in v and w.
const TEXEL: f64 = 2.0 / RESOLUTION as f64;
/// Minimum distance of a compared point from a shadow edge, in texels.
const CLEARANCE: f64 = 2.0;

/// Cosine between normal and light below which the width of a texel spans too much of the light.
const EDGE_ON: f64 = 0.1;

/// A point of a surface, in tube space.
pub struct WalkReceiver<'a> {
    pub root: &'a TubeRoot<f64>,
    /// Unit normal towards the camera: light from behind does not reach this side.
    pub normal: DVec3,
}

/// True if light reaches a point. `None` if rounding or the texels of the map can decide.
///
/// `triangles` are in tube space. `reach` is the size at which the renderer rounds their corners.
pub fn light_reaches(tube: &Tube<f64>, triangles: &[[DVec3; 3]], reach: f64, receiver: &WalkReceiver) -> Option<bool> {
    let WalkReceiver { root, normal } = receiver;
    let t = root.segment as f64 + root.u;
    let (v, w) = (root.v_len / root.radius, root.w_len / root.radius);
    let width = TEXEL * root.radius;
    // Tangent of the light path by a finite difference.
    let h = 1e-6;
    let tangent = (point_at(tube, t + h, v, w) - point_at(tube, t - h, v, w)) / (2.0 * h);
    let facing = -normal.dot(tangent) / tangent.length();
    if facing < -EDGE_ON {
        return Some(false);
    }
    if facing < EDGE_ON || 16.0 * eps::<f32>() * reach > 0.25 * width {
        return None;
    }
    // Change of t over the width of a texel, along the light and along the receiver.
    let segment = &tube.segments[root.segment].curve;
    let slowest = tangent.length().min(2.0 * segment.d(root.u).length());
    let per_texel = width / slowest + width / (facing * tangent.length());
    let window = 3.0 * CLEARANCE * per_texel;
    let end = if tube.end_mode() == EndMode::Cut { tube.n as f64 } else { f64::INFINITY };
    let paths: [Path; 9] = std::array::from_fn(|k| {
        let [dv, dw] = [k % 3, k / 3].map(|step| (step as f64 - 1.0) * CLEARANCE * TEXEL);
        Path::new(tube, v + dv, w + dw, (t + window).min(end))
    });
    let point = segment.position(root.u) + root.r;
    let known = paths.iter().all(|path| path.is_clear_where_thin(triangles, reach))
        && is_flat(&paths, point, *normal, t, per_texel);
    if !known {
        return None;
    }
    let own: Vec<bool> = triangles
        .iter()
        .map(|[a, b, c]| {
            let across = (b - a).cross(c - a).normalize_or_zero();
            across.dot(point - a).abs() < 1e-5 * reach.max(1.0) && across.cross(*normal).length() < 1e-3
        })
        .collect();
    let mut blocked = paths.iter().map(|path| path.is_blocked(triangles, &own, t - window));
    let first = blocked.next()??;
    blocked.all(|other| other == Some(first)).then_some(!first)
}

/// True if the receiver's plane is nearly flat on the map in the neighbourhood that the nine paths span. The renderer
/// compares texels by the slope of the plane.
fn is_flat(paths: &[Path; 9], point: DVec3, normal: DVec3, t: f64, per_texel: f64) -> bool {
    let off = |k: usize| {
        let crossings = paths[k].crossings(point, normal).map(|(at, _)| at - t);
        crossings.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    };
    (0..4).all(|k| matches!((off(k), off(8 - k)), (Some(a), Some(b)) if (a + b).abs() < per_texel))
}

/// A light path as a polyline per segment. At a corner, where control points coincide, the next polyline begins at a
/// different position.
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
                (from + u, point_in(tube, i, u, v, w), tube.segments[i].curve.radius(u))
            };
            (0..=STEPS).map(vertex).collect()
        };
        Self { pieces: (0..tube.segments.len()).filter(|&i| end > i as f64).map(piece).collect() }
    }

    /// True if no triangle is near a part of the tube that is so thin that rounding moves the triangle by texels.
    fn is_clear_where_thin(&self, triangles: &[[DVec3; 3]], reach: f64) -> bool {
        let thin = 64.0 * eps::<f32>() * reach * f64::from(RESOLUTION);
        let thin_part = || self.pieces.iter().flatten().filter(|(_, _, radius)| *radius < thin);
        triangles.iter().all(|&[a, b, c]| {
            let middle = (a + b + c) / 3.0;
            let size = [a, b, c].iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
            let normal = (b - a).cross(c - a).normalize_or_zero();
            thin_part().all(|&(_, p, _)| normal.dot(p - a).abs() > 4.0 * thin || p.distance(middle) > size + 4.0 * thin)
        })
    }

    /// True if a triangle blocks the path before `t_near`. `None` if a triangle that is not among the receiver's `own`
    /// meets the rest of the path.
    fn is_blocked(&self, triangles: &[[DVec3; 3]], own: &[bool], t_near: f64) -> Option<bool> {
        let mut blocked = false;
        for (&triangle, &own) in triangles.iter().zip(own) {
            for t in self.hits(triangle) {
                if t < t_near {
                    blocked = true;
                } else if !own {
                    return None;
                }
            }
        }
        Some(blocked)
    }

    /// Returns every t at which the path meets the triangle.
    fn hits(&self, [a, b, c]: [DVec3; 3]) -> impl Iterator<Item = f64> {
        let (e1, e2) = (b - a, c - a);
        let normal = e1.cross(e2);
        let area2 = normal.length_squared();
        let inside = move |at: DVec3| {
            let (beta, gamma) = (at.cross(e2).dot(normal) / area2, e1.cross(at).dot(normal) / area2);
            beta >= 0.0 && gamma >= 0.0 && beta + gamma <= 1.0
        };
        self.crossings(a, normal).filter(move |&(_, p)| inside(p - a)).map(|(t, _)| t)
    }

    /// Returns every t and position at which the path crosses a plane.
    fn crossings(&self, point: DVec3, normal: DVec3) -> impl Iterator<Item = (f64, DVec3)> {
        let pairs = self.pieces.iter().flat_map(|piece| piece.windows(2));
        pairs.filter_map(move |pair| {
            let [(t0, p0, _), (t1, p1, _)] = [pair[0], pair[1]];
            let (s0, s1) = (normal.dot(p0 - point), normal.dot(p1 - point));
            let share = s0 / (s0 - s1);
            ((s0 < 0.0) != (s1 < 0.0)).then(|| (t0 + (t1 - t0) * share, p0 + (p1 - p0) * share))
        })
    }
}

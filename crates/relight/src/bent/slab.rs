//! Mapping of points into tube space, slab by slab, like `map_to_slab` of `bent_map.wgsl`.

use glam::{Mat4, Vec3};
use light::{Curve, FrameMode, Lanes, Mask, increasing_roots};

use super::splat_curve;
use crate::lanes::{F32s, LANES, Masks, Vec3s};

/// Piece of the tube between two planes orthogonal to its curve. Within the piece and its box the map is one to one.
#[derive(Clone, Copy, Debug)]
pub struct MapSlab {
    pub curve: Curve<f32>,
    /// Map's t at the start of the slab.
    pub t_start: f32,
    /// Map's t per unit of the curve's parameter.
    pub t_span: f32,
    /// Bounding planes n.q + w, ends first; zero or more inside.
    pub planes: [[f32; 4]; 6],
    /// Bounds `[p, q, r, s]` under which an edge is surely straight: `(p dt + q e) dt` is at most the smaller radius of
    /// its ends and `r dt + s e` at most 1, for an edge of length e between parameters that differ by dt.
    pub edge_bounds: [f32; 4],
}

/// Tube space of a light, relative to scene space.
#[derive(Clone, Copy, Debug)]
pub struct TubeSpace {
    /// Transform from scene space.
    pub from_scene: Mat4,
    /// Orientation of the cross-section.
    pub frame: FrameMode,
    /// Unit vector that orients the cross-section with [`FrameMode::Up`].
    pub up: Vec3,
}

/// Slab with each of its numbers in all lanes.
#[derive(Debug)]
pub(super) struct SlabLanes {
    pub curve: Curve<F32s>,
    t_start: F32s,
    t_span: F32s,
    planes: [(Vec3s, F32s); 6],
}

/// Coordinates (V, W, R, t) of one point, or of one point per lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct TubePosition<F> {
    pub v: F,
    pub w: F,
    pub r: F,
    pub t: F,
}

impl TubeSpace {
    /// Transforms a position in the scene to tube space.
    #[inline(always)]
    pub(super) fn position(&self, [x, y, z]: [f32; 3]) -> Vec3 {
        let m = &self.from_scene;
        m.x_axis.truncate() * x + m.y_axis.truncate() * y + m.z_axis.truncate() * z + m.w_axis.truncate()
    }
}

impl SlabLanes {
    pub fn new(slab: &MapSlab) -> Self {
        let plane = |[x, y, z, w]: [f32; 4]| (Vec3s::splat([x, y, z]), F32s::splat(w));
        Self {
            curve: splat_curve(&slab.curve),
            t_start: F32s::splat(slab.t_start),
            t_span: F32s::splat(slab.t_span),
            planes: slab.planes.map(plane),
        }
    }

    /// Returns the signed distance from a bounding plane. A point is inside if all six are zero or more.
    #[inline(always)]
    pub fn distance(&self, plane: usize, q: Vec3s) -> F32s {
        let (normal, offset) = self.planes[plane];
        F32s::dot(normal, q) + offset
    }

    /// Returns the lanes whose points lie in the slab.
    #[inline(always)]
    pub fn holds(&self, q: Vec3s) -> Masks {
        let ends = self.distance(0, q).least(self.distance(1, q));
        let inside = ends.ge(F32s::splat(0.0));
        if !inside.any() {
            return inside;
        }
        let across = self.distance(2, q).least(self.distance(3, q));
        let along_normal = self.distance(4, q).least(self.distance(5, q));
        inside & across.least(along_normal).ge(F32s::splat(0.0))
    }

    /// Computes the tube coordinates of points in the slab. The signs at the ends are taken as known, so that rounding
    /// at a clipping plane does not lose the root.
    #[inline(always)]
    pub fn to_tube_position(&self, space: &TubeSpace, q: Vec3s) -> TubePosition<F32s> {
        let (zero, curve) = (F32s::splat(0.0), &self.curve);
        let f0 = (-F32s::dot(q - curve.b0, curve.d0)).least(zero);
        let f1 = (-F32s::dot(q - curve.b2, curve.d1)).most(zero);
        let roots = increasing_roots(curve, q, f0, f1);
        let mut u = f0 / (f0 - f1).least(F32s::splat(-1e-30));
        u = F32s::select(roots.has_right, roots.right, u);
        u = F32s::select(roots.has_left, roots.left, u);
        let both = roots.has_left & roots.has_right;
        if both.any() {
            let (right, left) = (curve.offset(q, roots.right), curve.offset(q, roots.left));
            let nearer = F32s::dot(right, right).lt(F32s::dot(left, left));
            u = F32s::select(both & nearer, roots.right, u);
        }
        let u_hat = curve.u_hat(u);
        let (v_hat, w_hat) = match space.frame {
            FrameMode::RotationMinimizing => curve.rotation_minimizing(u_hat),
            FrameMode::Up => {
                let w_hat = light::perpendicular_up::<F32s>(Vec3s::splat(space.up.to_array()), u_hat);
                (F32s::cross(w_hat, u_hat), w_hat)
            }
        };
        let r = curve.offset(q, u);
        TubePosition {
            v: F32s::dot(r, v_hat),
            w: F32s::dot(r, w_hat),
            r: curve.radius(u).most(zero),
            t: self.t_start + self.t_span * u,
        }
    }
}

impl TubePosition<F32s> {
    /// Returns the coordinates of one lane.
    #[inline(always)]
    pub fn lane(&self, lane: usize) -> TubePosition<f32> {
        TubePosition { v: self.v.0[lane], w: self.w.0[lane], r: self.r.0[lane], t: self.t.0[lane] }
    }
}

impl TubePosition<f32> {
    /// Returns the homogeneous position and the value of a vertex for the rasterizer.
    #[inline(always)]
    pub fn corner(self) -> [f32; 4] {
        [self.v, self.w, self.r, self.t]
    }
}

/// Puts points into lanes. If there are fewer than lanes, repeats the last point. `points` must not be empty.
#[inline(always)]
pub(super) fn lanes_from_points(points: &[Vec3]) -> Vec3s {
    let mut lanes = Vec3s::splat([0.0; 3]);
    let last = points.len() - 1;
    for i in 0..LANES {
        let point = points[i.min(last)];
        (lanes.x.0[i], lanes.y.0[i], lanes.z.0[i]) = (point.x, point.y, point.z);
    }
    lanes
}

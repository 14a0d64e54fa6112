//! Visibility of a bent light, like `bent_visibility` of `bendy.wgsl`.

use light::{Lanes, Mask, TubeRoot};

use super::lookup::{MapTexel, Pair, map_texel};
use super::{BentMapParams, RelitBent};
use crate::CasterScene;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::nearby::{self, ReceiverPoint};
use crate::surfaces::SurfaceLanes;
use crate::visibility::{
    Facing, GRAZING_TEXELS, LitTexels, Receiver, facing, filter_visibility, gathered, needs_exact_trace,
    resolve_visibility,
};

/// Run, in texel widths, above which ray tests against the scene decide in any case.
const EDGE_ON: f32 = 256.0;
/// Largest run, in texel widths, that increases the tolerance of the map.
const MAX_RUN_TEXELS: f32 = 4.0;
/// Largest run, in texel widths, that increases the tolerance for casters which deviate from the surface.
const MAX_CASTER_RUN_TEXELS: f32 = 32.0;
/// Run that is assumed for a plane seen edge on, in texel widths.
const EDGE_ON_RUN_TEXELS: f32 = 4096.0;
/// Distance along the light, in texel widths, within which ray tests against the scene decide about casters if light
/// grazes.
const REACH_TEXELS: f32 = 48.0;
/// Distance along the light, in texel widths, within which ray tests against the scene decide about casters if light
/// does not graze.
const NEAR_REACH_TEXELS: f32 = 8.0;
/// Number of texel steps from the receiver to the farthest texel that the filter reads. Ray tests also decide about
/// casters within the plane's run over this many steps.
const STEPS_AROUND: f32 = 1.5;
/// Longest first piece of a traced path, in texel widths. Each further piece is as long as all pieces that are nearer
/// to the surface together, because a chord deviates less the nearer it is to the surface. The chord of the first piece
/// deviates by some hundredths of a texel.
const FIRST_PIECE: f32 = 16.0;
/// Most pieces of a traced path. If this many do not suffice, the first piece is longer.
const MAX_PIECES: usize = 12;

/// Position of receivers on the map, and the planes that they lie in.
struct BentReceiver {
    face: U32s,
    texel: Pair,
    /// Depth of the receiver in the unit of the face, and its change along the receiver's plane from one texel to the
    /// next.
    depth: F32s,
    step: Pair,
    /// Distance behind the stored depth up to which a receiver is lit. `tolerance` is the distance if the map alone
    /// decides. `reach` is the greater distance if ray tests against the scene decide about the casters in between.
    tolerance: F32s,
    reach: F32s,
    /// Depth that corresponds to a stored value of 1.
    far: F32s,
    /// Width of a texel, as a depth.
    width: F32s,
    /// Lanes in which light grazes.
    grazes: Masks,
}

impl Receiver for BentReceiver {
    #[inline(always)]
    fn texel(&self) -> Pair {
        self.texel
    }

    #[inline(always)]
    fn lit_texels(&self, map: &DepthMap, corner: Pair) -> LitTexels {
        let (zero, side) = (F32s::splat(0.0), map.side() as f32);
        // If the tube's rim touches the map's, a lookup beyond it reads one texel further in. Farther out nothing
        // casts shadows, though surfaces that cast none are drawn up to the map's border.
        let (low, high) = (F32s::splat(-1.5), F32s::splat(side + 0.5));
        let beyond = self.texel[0].lt(low) | self.texel[1].lt(low) | self.texel[0].gt(high) | self.texel[1].gt(high);
        let last = F32s::splat(side - 2.0);
        let first = [corner[0].within(zero, last), corner[1].within(zero, last)];
        let [dx, dy] = self.step;
        let start = self.depth + (dx * (first[0] - self.texel[0]) + dy * (first[1] - self.texel[1]));
        let expected = [start, start + dx, start + dy, start + (dx + dy)];
        // A texel without a triangle holds the last depth, and a receiver's plane may run past that.
        let latest = self.far * F32s::splat(1.0 - 1.0 / 4_194_304.0);
        let stored = gathered(map, self.face, first);
        let mut lit = LitTexels { resolved: [beyond; 4], deferred: [beyond; 4] };
        for k in 0..4 {
            let stored = stored[k] * self.far;
            lit.resolved[k] = lit.resolved[k] | stored.ge((expected[k] - self.tolerance).least(latest));
            lit.deferred[k] = lit.deferred[k] | stored.ge((expected[k] - self.reach).least(latest));
        }
        lit
    }
}

/// Derivatives of a light path at a root, and the frame of the cross-section there.
pub(super) struct PathFrame<'a> {
    root: &'a TubeRoot<F32s>,
    v: F32s,
    w: F32s,
    v_hat: Vec3s,
    w_hat: Vec3s,
    /// Half the first derivative of the curve's position by u. The next field is half the second derivative.
    d: Vec3s,
    a: Vec3s,
    u_hat_derivative: Vec3s,
    radius_derivative: F32s,
    /// Derivative of position by t along the light path, the curve of constant (v, w).
    tangent: Vec3s,
    /// Rotation of the frame about the tangent per unit of u.
    twist: F32s,
    center_speed: F32s,
}

/// Tube coordinates of a point near a root, relative to the root. The point may be outside the tube.
struct OffsetPoint {
    dt: F32s,
    vw_len: Pair,
    radius: F32s,
}

impl RelitBent {
    #[inline(always)]
    pub(super) fn path<'a>(&self, root: &'a TubeRoot<F32s>, v: F32s, w: F32s) -> PathFrame<'a> {
        let curve = &self.tube.segments[root.segment].curve;
        let (v_hat, w_hat) = (root.v_hat, F32s::cross(root.u_hat, root.v_hat));
        let d = curve.d(root.u);
        let u_hat_derivative = curve.u_hat_derivative(root.u, root.u_hat);
        let radius_derivative = curve.radius_derivative(root.u);
        let twist = self.tube.twist(root, u_hat_derivative);
        let center_speed = F32s::splat(2.0) * F32s::length(d);
        let tangent = root.u_hat * (center_speed - F32s::dot(root.r, u_hat_derivative))
            + (v_hat * v + w_hat * w) * radius_derivative
            + F32s::cross(root.u_hat, root.r) * twist;
        let a = curve.a;
        PathFrame { root, v, w, v_hat, w_hat, d, a, u_hat_derivative, radius_derivative, tangent, twist, center_speed }
    }

    /// Computes the tube coordinates of a point at the short distance `lift` from a root, to second order. `sigma` is
    /// `|P'| - r . u_hat'`.
    #[inline(always)]
    fn offset_point(&self, path: &PathFrame, lift: Vec3s, sigma: F32s) -> OffsetPoint {
        let root = path.root;
        let (zero, one, two) = (F32s::splat(0.0), F32s::splat(1.0), F32s::splat(2.0));
        let curve = &self.tube.segments[root.segment].curve;
        // grad t = u_hat / sigma, and from there a step of Newton's method on r . P'.
        let rough = F32s::dot(lift, root.u_hat) / sigma.most(F32s::splat(1e-20));
        let d = path.d + path.a * rough;
        let r = root.r + lift - (path.d * two + path.a * rough) * rough;
        let slope = two * F32s::dot(d, d) - F32s::dot(r, path.a);
        let dt = rough + F32s::select(slope.gt(zero), F32s::dot(r, d) / slope, zero);
        let r_there = root.r + lift - (path.d * two + path.a * dt) * dt;
        let d_there = path.d + path.a * dt;
        let u_hat = d_there * (one / F32s::dot(d_there, d_there).most(F32s::splat(1e-37)).sqrt());
        // The frame turns with the tangent. A frame that leans towards `up` also turns about it.
        let turn = F32s::dot(root.v_hat, u_hat) / (one + F32s::dot(root.u_hat, u_hat));
        let v_hat = root.v_hat - (root.u_hat + u_hat) * turn;
        let v_len = F32s::dot(r_there, v_hat);
        let w_len = F32s::dot(r_there, F32s::cross(u_hat, v_hat));
        let turned = path.twist * dt;
        let radius = root.radius + (path.radius_derivative + curve.ar * dt) * dt;
        OffsetPoint { dt, vw_len: [v_len + turned * w_len, w_len - turned * v_len], radius: radius.most(zero) }
    }

    /// Computes the share of the light that no caster blocks, for the `active` lanes.
    ///
    /// The receiver's own plane has a t at each texel's center, and that t is compared with the texel, so that no plane
    /// shadows itself: a step e in the plane is `R (dv v_hat + dw w_hat) + T dt` with T the path's tangent, and n.e = 0
    /// gives `dt = -R (n_v dv + n_w dw) / n.T`.
    #[inline(always)]
    pub(super) fn visibility(
        &self,
        scene: &CasterScene,
        map: &DepthMap,
        surface: &SurfaceLanes,
        path: &PathFrame,
        active: Masks,
    ) -> F32s {
        let (zero, root) = (F32s::ZERO, path.root);
        let arriving = self.world_from_tube.vector(path.tangent);
        let arriving = arriving * (F32s::splat(-1.0) / F32s::length(arriving));
        let Facing { active, faces_light, normal } = facing(scene, surface, arriving, active);
        if !active.any() {
            return zero;
        }
        let curvature = F32s::dot(root.r, path.u_hat_derivative);
        let sigma = (path.center_speed - curvature).most(F32s::splat(0.1) * path.center_speed);
        let world_per_tube = F32s::splat(self.world_per_tube);
        let lift =
            self.world_from_tube.transposed_vector(surface.normal) * (surface.terminator_offset / world_per_tube);
        let lifted = self.offset_point(path, lift, sigma);
        let on_map = map_texel(&self.map, map.side() as f32, lifted.vw_len, lifted.radius);

        let normal = self.world_from_tube.transposed_vector(normal);
        let receiver = self.receiver(path, &lifted, &on_map, normal, faces_light);
        let (width, run) = (receiver.width, length2(receiver.step));
        let shares = filter_visibility(&receiver, map, self.map.filter);
        let is_deferred = needs_exact_trace(shares, receiver.grazes) | shares.resolved.lt(shares.deferred);
        let is_edge_on = run.gt(F32s::splat(EDGE_ON) * width) & shares.deferred.gt(zero);
        let traced = active & (is_deferred | is_edge_on);
        // A steep caster beside the receiver may be nearer than at it, so the ray test covers twice the reach.
        let two = F32s::splat(2.0);
        let back = F32s::select(is_deferred, two * receiver.reach + run, two * F32s::splat(REACH_TEXELS) * width);
        let back = back / on_map.gain;
        let t = F32s::splat(root.segment as f32) + root.u + lifted.dt;
        let radii = F32s::select(lifted.radius.gt(zero), lifted.radius, F32s::splat(1.0));
        let (v, w) = (lifted.vw_len[0] / radii, lifted.vw_len[1] / radii);
        let visibility = resolve_visibility(shares, traced, |i| {
            let first = FIRST_PIECE * width.0[i] / on_map.gain.0[i];
            let [t, v, w, back] = [t, v, w, back].map(|x| x.0[i]);
            let reaches = |pieces: &usize| first * (1_u32 << (pieces - 1)) as f32 >= back;
            let pieces = (1..MAX_PIECES).find(reaches).unwrap_or(MAX_PIECES);
            self.is_path_occluded(scene, &surface.receiver_point(i), [t, v, w], back, pieces, faces_light.lane(i))
        });
        F32s::select(active, visibility, zero)
    }

    /// Makes the receivers for planes with the unit vector `normal` in tube space.
    #[inline(always)]
    fn receiver(
        &self,
        path: &PathFrame,
        lifted: &OffsetPoint,
        on_map: &MapTexel,
        normal: Vec3s,
        faces_light: Masks,
    ) -> BentReceiver {
        let (map, root) = (&self.map, path.root);
        let t = F32s::splat(root.segment as f32) + root.u + lifted.dt - F32s::splat(map.t_base);
        let leaning = [F32s::dot(normal, path.v_hat), F32s::dot(normal, path.w_hat)];
        // Texel width in the scene as a step in t, at most that at the speed by which the map's own error is measured.
        let speed = F32s::length(path.tangent).least(map_speed(map, path)).most(F32s::splat(1e-20));
        let footprint = texel_width(map, on_map, lifted.radius, path) / speed;
        // A plane seen edge on runs off along the light within a texel, in the direction in which it leans.
        let edge_on = length2(leaning) * speed;
        let facing = (-F32s::dot(normal, path.tangent)).most(edge_on * F32s::splat(1.0 / EDGE_ON_RUN_TEXELS));
        let caster_facing = facing.most(edge_on * F32s::splat(1.0 / MAX_CASTER_RUN_TEXELS));
        let rise = lifted.radius / facing;
        let step = [
            rise * dot2(leaning, on_map.right) * on_map.gain,
            rise * dot2(leaning, on_map.down) * on_map.gain + t * on_map.gain_down,
        ];
        // Rounding changes the depth by some ulps of the largest. The receiver's own caster may deviate by e towards
        // the light: a plane moved so far along its normal is met e / (n . T) earlier.
        let width = footprint * on_map.gain;
        let run = length2(step);
        let grazes = !faces_light | run.gt(F32s::splat(GRAZING_TEXELS) * width);
        let near = F32s::select(grazes, F32s::splat(REACH_TEXELS), F32s::splat(NEAR_REACH_TEXELS)) * width;
        let rounding = F32s::splat(map.t_last / 4_194_304.0) + F32s::splat(map.mesh_error) / caster_facing;
        let tolerance = F32s::splat(map.tolerance_texels) * (width + run.least(F32s::splat(MAX_RUN_TEXELS) * width))
            + rounding * on_map.gain;
        BentReceiver {
            face: on_map.face,
            texel: on_map.texel,
            depth: t * on_map.gain,
            step,
            tolerance,
            reach: tolerance.most(near.most(F32s::splat(STEPS_AROUND) * run)),
            far: on_map.far,
            width,
            grazes,
        }
    }
}

impl RelitBent {
    /// Computes the points at `t` on the paths of constant (v, w), in tube space.
    #[inline(always)]
    fn path_points(&self, t: F32s, v: F32s, w: F32s) -> Vec3s {
        let mut points = Vec3s::splat([0.0; 3]);
        let last = self.tube.segments.len() - 1;
        for (i, segment) in self.tube.segments.iter().enumerate() {
            let (first, curve) = (F32s::splat(i as f32), &segment.curve);
            let here = t.ge(first) & (t.lt(first + F32s::splat(1.0)) | Masks::of(i == last));
            if here.any() {
                let u = t - first;
                let (v_hat, w_hat) = self.tube.cross_section(curve, curve.u_hat(u));
                let radius = curve.radius(u);
                let point = curve.position(u) + v_hat * (v * radius) + w_hat * (w * radius);
                points = F32s::select_vec(here, point, points);
            }
        }
        points
    }

    /// True if a caster lies on the end of the path of constant (v, w) to a surface: from `t - back` to `t`, traced in
    /// `pieces` chords.
    fn is_path_occluded(
        &self,
        scene: &CasterScene,
        surface: &ReceiverPoint,
        [t, v, w]: [f32; 3],
        back: f32,
        pieces: usize,
        faces_light: bool,
    ) -> bool {
        // Each piece's far end takes a lane, and the end of the path the next.
        let mut ends = F32s::splat(t);
        for piece in 0..pieces {
            let share = 1.0 / (1 << (pieces - 1 - piece)) as f32;
            ends.0[piece] = (t - back * share).max(0.0);
        }
        let points = self.path_points(ends, F32s::splat(v), F32s::splat(w));
        let from_end = points - Vec3s::splat(points.lane(pieces).to_array());
        let offsets = self.world_from_tube.vector(from_end) * F32s::splat(self.world_per_tube);
        let end = surface.shadow_position();
        // Bent light may already have passed through the surface's own triangle.
        if faces_light && nearby::crosses_own_triangle(scene, surface, end + offsets.lane(0)) {
            return true;
        }
        let (mut before, mut own) = (end, Some(surface.triangle));
        for piece in 0..pieces {
            let here = end + offsets.lane(piece);
            if nearby::is_segment_occluded(scene, (before, here - before), own, surface.depth) {
                return true;
            }
            (before, own) = (here, None);
        }
        false
    }
}

/// Returns the speed of the light path at (v, w) that relates the map's error along the light to t. On a wide cone it
/// differs much from the speed at the center.
#[inline(always)]
fn map_speed(map: &BentMapParams, path: &PathFrame) -> F32s {
    if map.slope.is_none() {
        return path.center_speed;
    }
    length2([path.center_speed, path.radius_derivative * length2([path.v, path.w])])
}

/// Returns the distance in the scene, orthogonal to the path, that a step of (v, w) from one texel to the next covers.
#[inline(always)]
fn texel_width(map: &BentMapParams, texel: &MapTexel, radius: F32s, path: &PathFrame) -> F32s {
    if map.slope.is_none() {
        return radius * length2(texel.right).most(length2(texel.down));
    }
    // Far from the axis of a wide cone, directions across the tube are almost along the path.
    let along = path.tangent * (F32s::splat(1.0) / F32s::length(path.tangent));
    let right = path.v_hat * texel.right[0] + path.w_hat * texel.right[1];
    let down = path.v_hat * texel.down[0] + path.w_hat * texel.down[1];
    let right = right - along * F32s::dot(right, along);
    let down = down - along * F32s::dot(down, along);
    radius * F32s::length(right).most(F32s::length(down))
}

#[inline(always)]
fn dot2(a: Pair, b: Pair) -> F32s {
    a[0] * b[0] + a[1] * b[1]
}

#[inline(always)]
fn length2(a: Pair) -> F32s {
    dot2(a, a).sqrt()
}

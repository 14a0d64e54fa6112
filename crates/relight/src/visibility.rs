//! Percentage-closer filters, like `shadow_filter.wgsl`: each texel is compared by itself, and the answers are blended.

use light::{Lanes, Mask};

use crate::depth_map::DepthMap;
use crate::lanes::{F32s, LANES, Masks, U32s, Vec3s};
use crate::nearby::{self, ReceiverPoint};
use crate::surfaces::SurfaceLanes;
use crate::{CasterScene, ShadowFilter};

/// Run of the receiver's plane, in texel widths, above which light counts as grazing, and ray tests against the scene
/// decide where the map cannot. The run is the distance along the light by which the plane changes from one texel to
/// the next.
pub(crate) const GRAZING_TEXELS: f32 = 1.0;

/// Receivers in sixteen lanes, with their position on a shadow map. Each shape of light has its own type.
pub(crate) trait Receiver {
    /// Returns the position in texels from the center of the first texel.
    fn texel(&self) -> [F32s; 2];
    /// Compares the four texels from `corner` on, row by row, with the receivers.
    fn lit_texels(&self, map: &DepthMap, corner: [F32s; 2]) -> LitTexels;
}

/// For each of four texels, row by row: the lanes whose receiver the texel leaves lit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LitTexels {
    /// Lanes that are lit if the map alone decides.
    pub resolved: [Masks; 4],
    /// Lanes that are lit if the map ignores casters near the receiver. Ray tests against the scene decide about those
    /// casters.
    pub deferred: [Masks; 4],
}

/// Shares of the light that a filter lets through, for both cases of [`LitTexels`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct VisibilityShares {
    pub resolved: F32s,
    pub deferred: F32s,
}

/// Loads the four texels from a corner on, row by row. Coordinates beyond the map are clamped to its border.
#[inline(always)]
pub(crate) fn gathered(map: &DepthMap, face: U32s, corner: [F32s; 2]) -> [F32s; 4] {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let mut found = [zero; 4];
    let (side, texels) = (map.side(), map.texels());
    let last = F32s::splat(side as f32 - 1.0);
    let stride = map.stride();
    let (width, first) = (U32s::splat(stride as u32), face * U32s::splat((side * stride) as u32));
    let left = corner[0].within(zero, last).to_u32();
    let right = (corner[0] + one).within(zero, last).to_u32();
    let top = first + corner[1].within(zero, last).to_u32() * width;
    let bottom = first + (corner[1] + one).within(zero, last).to_u32() * width;
    for i in 0..LANES {
        let (left, right) = (left.0[i], right.0[i]);
        let (top, bottom) = (top.0[i], bottom.0[i]);
        found[0].0[i] = texel(texels, top.wrapping_add(left));
        found[1].0[i] = texel(texels, top.wrapping_add(right));
        found[2].0[i] = texel(texels, bottom.wrapping_add(left));
        found[3].0[i] = texel(texels, bottom.wrapping_add(right));
    }
    found
}

/// Returns the lanes in which each of the four texels from a corner on lies beyond a map of `side` texels, row by row.
///
/// Nothing casts shadows there: maps are fitted to the casters, and floors and walls left out of the fit are drawn up
/// to the border.
#[inline(always)]
pub(crate) fn beyond_map(corner: [F32s; 2], side: usize) -> [Masks; 4] {
    let (zero, one, side) = (F32s::splat(0.0), F32s::splat(1.0), F32s::splat(side as f32));
    let (next_x, next_y) = (corner[0] + one, corner[1] + one);
    let (left, right) = (corner[0].lt(zero) | corner[0].ge(side), next_x.lt(zero) | next_x.ge(side));
    let (top, bottom) = (corner[1].lt(zero) | corner[1].ge(side), next_y.lt(zero) | next_y.ge(side));
    [left | top, right | top, left | bottom, right | bottom]
}

/// Loads a texel. Returns 0 if the index is beyond all texels.
#[inline(always)]
fn texel(texels: &[f32], at: u32) -> f32 {
    texels.get(at as usize).copied().unwrap_or(0.0)
}

/// Adds four texels, weighted by column and row. The sum is 1 to the last bit if all are lit.
#[inline(always)]
fn weighted(lit: &[Masks; 4], columns: [F32s; 2], rows: [F32s; 2]) -> F32s {
    let top = columns[0] * mask_to_float(lit[0]) + columns[1] * mask_to_float(lit[1]);
    let bottom = columns[0] * mask_to_float(lit[2]) + columns[1] * mask_to_float(lit[3]);
    rows[0] * top + rows[1] * bottom
}

/// Returns 1 in lit lanes, else 0.
#[inline(always)]
fn mask_to_float(lit: Masks) -> F32s {
    F32s::select(lit, F32s::splat(1.0), F32s::splat(0.0))
}

#[inline(always)]
fn weighted_both(lit: &LitTexels, columns: [F32s; 2], rows: [F32s; 2]) -> VisibilityShares {
    VisibilityShares {
        resolved: weighted(&lit.resolved, columns, rows),
        deferred: weighted(&lit.deferred, columns, rows),
    }
}

/// Computes the shares of the light that `filter` lets through.
#[inline(always)]
pub(crate) fn filter_visibility<R: Receiver>(receiver: &R, map: &DepthMap, filter: ShadowFilter) -> VisibilityShares {
    let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
    let [x, y] = receiver.texel();
    let first = [x.floor(), y.floor()];
    let mut blend = [x - first[0], y - first[1]];
    if filter == ShadowFilter::Nearest {
        let half = F32s::splat(0.5);
        blend = [F32s::select(blend[0].gt(half), one, zero), F32s::select(blend[1].gt(half), one, zero)];
    }
    if filter != ShadowFilter::Pcf3x3 {
        let columns = [one - blend[0], blend[0]];
        let rows = [one - blend[1], blend[1]];
        return weighted_both(&receiver.lit_texels(map, first), columns, rows);
    }
    let low = [[one - blend[0], one], [one - blend[1], one]];
    let high = [[one, blend[0]], [one, blend[1]]];
    let mut sum = VisibilityShares { resolved: zero, deferred: zero };
    for (columns, dx) in [(low[0], -1.0), (high[0], 1.0)] {
        for (rows, dy) in [(low[1], -1.0), (high[1], 1.0)] {
            let corner = [first[0] + F32s::splat(dx), first[1] + F32s::splat(dy)];
            let shares = weighted_both(&receiver.lit_texels(map, corner), columns, rows);
            (sum.resolved, sum.deferred) = (sum.resolved + shares.resolved, sum.deferred + shares.deferred);
        }
    }
    let ninth = F32s::splat(9.0);
    VisibilityShares { resolved: sum.resolved / ninth, deferred: sum.deferred / ninth }
}

/// Returns the lanes in which ray tests against the scene have to decide about near casters. In these lanes light
/// grazes, the map alone blocks at least a part of the light, and casters that are not near let at least a part of it
/// through.
#[inline(always)]
pub(crate) fn needs_exact_trace(shares: VisibilityShares, grazes: Masks) -> Masks {
    grazes & shares.resolved.lt(F32s::splat(1.0)) & shares.deferred.gt(F32s::splat(0.0))
}

/// Computes the share of the light that reaches the surface from both shares of [`filter_visibility`]. `traced` has the
/// lanes to test exactly. `is_blocked` tests such a lane for a caster on the last piece of the light path.
#[inline(always)]
pub(crate) fn resolve_visibility(shares: VisibilityShares, traced: Masks, is_blocked: impl Fn(usize) -> bool) -> F32s {
    if !traced.any() {
        return shares.resolved;
    }
    let mut visibility = shares.resolved;
    for i in 0..LANES {
        if traced.lane(i) {
            visibility.0[i] = if is_blocked(i) { 0.0 } else { shares.deferred.0[i] };
        }
    }
    visibility
}

/// Computes the share of the light that reaches the surface, for a straight last piece of the light path. `segment` is
/// the vector from the surface along that piece, towards the light.
#[inline(always)]
pub(crate) fn resolve_along_segment(
    scene: &CasterScene,
    surface: &SurfaceLanes,
    shares: VisibilityShares,
    grazes: Masks,
    segment: Vec3s,
) -> F32s {
    resolve_visibility(shares, needs_exact_trace(shares, grazes), |i| {
        let met = surface.receiver_point(i);
        nearby::is_segment_occluded(scene, (met.shadow_position(), segment.lane(i)), Some(met.triangle), met.depth)
    })
}

/// Result of testing on which side light meets surfaces.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facing {
    /// Lanes in which light meets the surface from the front, and the surface does not shadow itself.
    pub active: Masks,
    /// Lanes in which light meets the triangle from the front too.
    pub faces_light: Masks,
    /// Unit normal in scene space of the plane that is compared with a shadow map.
    pub normal: Vec3s,
}

/// Finds the side on which light meets the surfaces, in the `active` lanes. `to_light` are unit vectors towards the
/// light.
#[inline(always)]
pub(crate) fn facing(scene: &CasterScene, surface: &SurfaceLanes, to_light: Vec3s, active: Masks) -> Facing {
    let zero = F32s::splat(0.0);
    // Light from behind meets the other side of the surface.
    let active = active & F32s::dot(surface.normal, to_light).gt(zero);
    let active = active & !self_shadowed_lanes(scene, surface, to_light, active);
    // A facet that faces away lies behind the plane of the smooth surface.
    let faces_light = F32s::dot(surface.geometric_normal, to_light).gt(zero);
    let normal = F32s::select_vec(faces_light, surface.geometric_normal, surface.normal);
    Facing { active, faces_light, normal }
}

/// Returns the center and 1 / half size of the drawn part of each lane's face.
#[inline(always)]
pub(crate) fn fit_of(fits: &[[f32; 4]], face: U32s) -> [F32s; 4] {
    let [x, y, per_x, per_y] = fits[0];
    let mut fit = [F32s::splat(x), F32s::splat(y), F32s::splat(per_x), F32s::splat(per_y)];
    // Sixteen neighbouring pixels mostly lie on one face.
    for (other, numbers) in (1..).zip(&fits[1..]) {
        let here = face.equals(U32s::splat(other));
        if here.any() {
            for k in 0..4 {
                fit[k] = F32s::select(here, F32s::splat(numbers[k]), fit[k]);
            }
        }
    }
    fit
}

/// Computes a position in texels on a face with this fit and `side`, from the center of the first texel. y is up.
#[inline(always)]
pub(crate) fn texel_at(fit: [F32s; 4], [x, y]: [F32s; 2], side: F32s) -> [F32s; 2] {
    let half = F32s::splat(0.5);
    [((x - fit[0]) * fit[2] * half + half) * side - half, (half - (y - fit[1]) * fit[3] * half) * side - half]
}

/// Returns the `active` lanes whose surfaces shadow themselves. `arriving` are unit vectors towards the light.
#[inline(always)]
fn self_shadowed_lanes(scene: &CasterScene, surface: &SurfaceLanes, arriving: Vec3s, active: Masks) -> Masks {
    let faces_away = F32s::dot(surface.geometric_normal, arriving).le(F32s::splat(0.0));
    let mut shadowed = Masks::of(false);
    if !(active & faces_away).any() {
        return shadowed;
    }
    for i in 0..LANES {
        if (active & faces_away).lane(i)
            && nearby::is_self_shadowed(scene, &surface.receiver_point(i), arriving.lane(i))
        {
            shadowed.0[i] = u32::MAX;
        }
    }
    shadowed
}

impl SurfaceLanes {
    /// Returns the point at which light must arrive for each surface to be lit.
    #[inline(always)]
    pub fn shadow_position(&self) -> Vec3s {
        self.position + self.normal * self.terminator_offset
    }

    /// Returns the receiver of one lane, which must exist.
    pub(crate) fn receiver_point(&self, lane: usize) -> ReceiverPoint {
        ReceiverPoint {
            position: self.position.lane(lane),
            normal: self.normal.lane(lane),
            geometric_normal: self.geometric_normal.lane(lane),
            terminator_offset: self.terminator_offset.0[lane],
            depth: self.depth.0[lane],
            triangle: self.triangle.0[lane].wrapping_sub(1),
        }
    }
}

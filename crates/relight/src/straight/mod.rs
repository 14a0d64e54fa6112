//! Lights with straight rays: coordinates of surfaces in them, and their shadows by maps. Each shape has its own
//! coordinates and receiver. They share the drawing of maps, and the light at given coordinates.

mod alpha_tested;
mod casters;
mod directional;
mod map;
mod omni;
mod receiver;
mod spot;

use light::Lanes;

use crate::lanes::{F32s, Masks, Vec3s};

pub use casters::{AlphaTestedCasters, AlphaTestedRun, OpaqueCasters, StraightFace, StraightMap};
pub use directional::{DirectionalMapParams, RelitDirectional};
pub use map::StraightMapBuilder;
pub use omni::{OmniMapParams, RelitOmni};
pub use spot::{RelitSpot, SpotMapParams};

/// Distance along the light, in texel widths, up to which the receiver's plane is followed. Beyond it the plane is
/// followed only as far as the texels around the receiver need.
const REACH_TEXELS: f32 = 48.0;
/// Rounding error of depths that are linear across a triangle: some ulps of the largest depth of a map, 1.
const DEPTH_ROUNDING: f32 = 1.0 / 4_194_304.0;

/// Coordinates of surfaces in a light.
#[derive(Clone, Copy, Debug)]
struct Located {
    inside: Masks,
    /// Share of the light's range; 0 for a light without one.
    t: F32s,
    v: F32s,
    w: F32s,
    /// Length of the light path, in world units; 0 for a light whose irradiance does not depend on it.
    s: F32s,
    /// Unit vector towards the direction from which light comes, in scene space.
    to_light: Vec3s,
}

/// Returns the distance by which a neighbouring facet may rise out of the receiver's plane without counting as an
/// occluder: the rise of a facet that is tilted by 0.25 rad, which is a quarter of a texel's `width`, and more where
/// light grazes. `cosine`, with either sign, is the cosine of the angle between the light and the plane's normal.
#[inline(always)]
fn rise_of_facets(width: F32s, cosine: F32s) -> F32s {
    F32s::splat(0.25) * width / (cosine * cosine).most(F32s::splat(0.06))
}

/// Returns the relative error of 1 / depth that arises because the receiver's own caster may deviate by `error` from
/// the surface.
///
/// The source is `height` over the receiver's plane and `path_length` away. Moved by `error` along its normal, the
/// plane has a 1 / depth that is larger by the share `error / (height - error)`, at most by its own size. Light grazes
/// at a cosine of at least 0.1.
#[inline(always)]
fn depth_error(height: F32s, path_length: F32s, error: f32) -> F32s {
    let error = F32s::splat(error);
    let plane_height = height.most(F32s::splat(0.1) * path_length);
    let room = (plane_height - error).most(error);
    F32s::select(room.gt(F32s::splat(0.0)), error / room, F32s::splat(0.0))
}

/// Returns the share of the light path over which the receiver's plane is followed. Seen edge on, a plane extends to
/// the source or to infinity within one texel.
///
/// The share is `reach`, but at most half. It is more if the texels around the receiver need it, but never includes the
/// first tenth of the path. `run` is the run of the plane from texel to texel, as a share of the path too.
#[inline(always)]
fn followed_share(reach: F32s, run: F32s) -> F32s {
    let around = F32s::splat(1.5) * run;
    let to_texels_around = (around / (F32s::splat(1.0) + around)).least(F32s::splat(0.9));
    reach.least(F32s::splat(0.5)).most(to_texels_around)
}

#[cfg(test)]
mod tests;

//! Lights whose rays are straight: where surfaces lie in them, and what their maps say of them. Each shape has its own
//! place in the light, and its own receiver; they share the pass that draws maps, and what follows from a place.

mod alpha_tested;
mod casters;
mod directional;
mod map;
mod omni;
mod spot;

use glam::Mat4;
use light::{Lanes, LightProfile, Mask};

use crate::lanes::{F32s, Masks, Vec3s};
use crate::shape::LightSampleLanes;

pub use casters::{AlphaTestedCasters, AlphaTestedRun, StraightFace, StraightMap};
pub use directional::{DirectionalMapParams, RelitDirectional};
pub use map::StraightMapBuilder;
pub use omni::{OmniMapParams, RelitOmni};
pub use spot::{RelitSpot, SpotMapParams};

/// Lengths along the light, in a texel's widths. Where the receiver's plane runs farther than this from texel to texel,
/// what the map cannot tell the scene is asked; ...
const GRAZING_TEXELS: f32 = 1.0;
/// ... farther than this the plane is only followed as the texels around need.
const REACH_TEXELS: f32 = 48.0;
/// Some ulps of a map's largest depth, 1, by which depths that are linear across a triangle are off.
const DEPTH_ROUNDING: f32 = 1.0 / 4_194_304.0;
/// Largest share that stays finite through the BRDF: nothing is left of this much at the source itself.
const MAX_SHARE: f32 = 1e15;

/// From scene space to light space: the scene's axes, turned, about the light or the scene's origin.
#[derive(Clone, Copy, Debug)]
struct LightFrame {
    columns: [Vec3s; 3],
    shift: Vec3s,
}

impl LightFrame {
    fn new(light_from_scene: Mat4) -> Self {
        let [a, b, c, shift] =
            light_from_scene.to_cols_array_2d().map(|[x, y, z, _]| Vec3s::splat([x, y, z]));
        Self { columns: [a, b, c], shift }
    }

    #[inline(always)]
    fn position(&self, p: Vec3s) -> Vec3s {
        self.vector(p) + self.shift
    }

    #[inline(always)]
    fn vector(&self, v: Vec3s) -> Vec3s {
        self.columns[0] * v.x + self.columns[1] * v.y + self.columns[2] * v.z
    }

    /// A vector in light space, in the scene's axes.
    #[inline(always)]
    fn scene_vector(&self, v: Vec3s) -> Vec3s {
        Vec3s {
            x: F32s::dot(self.columns[0], v),
            y: F32s::dot(self.columns[1], v),
            z: F32s::dot(self.columns[2], v),
        }
    }
}

/// Where surfaces lie in a light.
#[derive(Clone, Copy, Debug)]
struct Located {
    inside: Masks,
    v: F32s,
    w: F32s,
    /// Length of light's way, in world units; 0 where nothing depends on it.
    s: F32s,
    /// Unit vector to where light comes from, in scene space.
    to_light: Vec3s,
}

impl Located {
    /// What surfaces there get of a light of that filter.
    #[inline(always)]
    fn sample(&self, filter: &LightProfile, visibility: F32s) -> LightSampleLanes {
        let most = F32s::splat(MAX_SHARE);
        let share = filter.attenuation_at(self.v, self.w, self.s);
        // At the source itself light would be infinitely strong.
        let share = F32s::select(share.le(most), share, most);
        LightSampleLanes {
            inside: self.inside,
            direction: self.to_light,
            irradiance: Vec3s { x: share, y: share, z: share },
            visibility,
        }
    }
}

/// A neighbouring facet that rises out of a plane by 0.25 rad is no occluder: a quarter of a texel's `width`, longer along the light
/// where it grazes, `cosine` being that of its angle with the plane's normal, with either sign.
#[inline(always)]
fn rise_of_facets(width: F32s, cosine: F32s) -> F32s {
    F32s::splat(0.25) * width / (cosine * cosine).most(F32s::splat(0.06))
}

/// The receiver's own caster may stray by `error` towards a source that is `height` over its plane and `way_length` away: moved so
/// far along its normal, its plane has 1 / depth larger by the share `error / (height - error)`, at most by its own size; light
/// grazes at a cosine of 0.1.
#[inline(always)]
fn depth_error(height: F32s, way_length: F32s, error: f32) -> F32s {
    let error = F32s::splat(error);
    let plane_height = height.most(F32s::splat(0.1) * way_length);
    let room = (plane_height - error).most(error);
    F32s::select(room.gt(F32s::splat(0.0)), error / room, F32s::splat(0.0))
}

/// Seen edge on, a plane runs off to the source or to infinity within a texel: by which share of light's way it is followed, `reach`
/// at most half of it, and farther to the texels around, but for the first tenth. `run` is how far it runs from one to the next, as
/// a share too.
#[inline(always)]
fn followed_share(reach: F32s, run: F32s) -> F32s {
    let around = F32s::splat(1.5) * run;
    let to_texels_around = (around / (F32s::splat(1.0) + around)).least(F32s::splat(0.9));
    reach.least(F32s::splat(0.5)).most(to_texels_around)
}

/// Nothing of a light that holds none of the surfaces.
#[inline(always)]
fn no_light() -> LightSampleLanes {
    let zero = Vec3s::splat([0.0; 3]);
    LightSampleLanes {
        inside: Masks::of(false),
        direction: zero,
        irradiance: zero,
        visibility: F32s::splat(0.0),
    }
}

#[cfg(test)]
mod tests;

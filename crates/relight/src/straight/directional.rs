//! Directional lights, like `parallel.wgsl` and `parallel_lookup.wgsl`. Light space has the light's axes about the
//! scene's origin. Light travels along -z.

use glam::Mat4;
use light::{Lanes, LightProfile};

use super::receiver::{MapDepths, StraightReceiver, StraightShape};
use super::{DEPTH_ROUNDING, Located, REACH_TEXELS, rise_of_facets};
use crate::ShadowFilter;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::surfaces::SurfaceLanes;
use crate::transform::Affine3s;
use crate::visibility::{GRAZING_TEXELS, fit_of, texel_at};

/// Directional light as it is drawn.
#[derive(Debug)]
pub struct RelitDirectional {
    /// Rotation from scene axes to light axes.
    light_from_scene: Affine3s,
    light_profile: LightProfile,
    window: [f32; 4],
    map: DirectionalMapParams,
}

/// Shadow map of a directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalMapParams {
    /// Center and 1 / half size of the map, along x and y.
    pub fit: [f32; 4],
    /// The z of depth 0. No part of the scene is below it.
    pub bottom: f32,
    /// Depth per world unit along z.
    pub depth_scale: f32,
    /// Largest distance of the casters, which may be simplified, from the scene's surface, in world units.
    pub mesh_error: f32,
    pub filter: ShadowFilter,
}

impl RelitDirectional {
    /// Makes a light that is ready to draw. `light_from_scene` rotates scene space to light space. The coordinates
    /// across the window are (-x, y) times the first two numbers of `window` plus the others: 0 for a window without
    /// end.
    pub fn new(
        light_from_scene: Mat4,
        light_profile: LightProfile,
        window: [f32; 4],
        map: DirectionalMapParams,
    ) -> Self {
        Self { light_from_scene: Affine3s::splat(light_from_scene), light_profile, window, map }
    }
}

/// Depths of a directional light's map. The receiver's surface is continued as a plane. The plane's value at a texel is
/// its rise from the receiver towards the light, in units of the map's depth.
pub(super) struct DirectionalDepths {
    receiver: F32s,
    /// Largest rise or fall of the plane at any texel. A larger one is clamped.
    most: F32s,
}

impl MapDepths for DirectionalDepths {
    #[inline(always)]
    fn lit(&self, stored: F32s, rise: F32s, [tolerance, reach]: [F32s; 2]) -> [Masks; 2] {
        // An empty texel holds 0, and nothing is below that.
        let plane = (self.receiver + rise.within(-self.most, self.most)).most(F32s::ZERO);
        [stored.le(plane + tolerance), stored.le(plane + reach)]
    }
}

impl StraightShape for RelitDirectional {
    type Depths = DirectionalDepths;

    fn profile(&self) -> &LightProfile {
        &self.light_profile
    }

    #[inline(always)]
    fn locate(&self, scene_position: Vec3s) -> Located {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let position = self.light_from_scene.vector(scene_position);
        let [scale_v, scale_w, shift_v, shift_w] = self.window;
        let v = F32s::splat(shift_v) - position.x * F32s::splat(scale_v);
        let w = position.y * F32s::splat(scale_w) + F32s::splat(shift_w);
        let toward = self.light_from_scene.transposed_vector(Vec3s { x: zero, y: zero, z: one });
        Located { inside: v.abs().le(one) & w.abs().le(one), t: zero, v, w, s: zero, to_light: toward }
    }

    #[inline(always)]
    fn receiver(&self, map: &DepthMap, surface: &SurfaceLanes, normal: Vec3s) -> StraightReceiver<DirectionalDepths> {
        let one = F32s::splat(1.0);
        let start = surface.shadow_position();
        let at = self.light_from_scene.vector(start);
        let normal = self.light_from_scene.vector(normal);
        let cosine = normal.z.most(F32s::splat(1e-20));
        let DirectionalMapParams { fit, bottom, depth_scale, mesh_error, .. } = &self.map;
        let [.., per_x, per_y] = fit;
        let (side, depth_scale) = (F32s::splat(map.side() as f32), F32s::splat(*depth_scale));
        // In world units.
        let texels = [2.0 / (per_x * map.side() as f32), 2.0 / (per_y * map.side() as f32)];
        let width = F32s::splat(texels[0].max(texels[1]));
        let rise = [-normal.x / cosine * F32s::splat(texels[0]), -normal.y / cosine * F32s::splat(texels[1])];
        let rise_length = (rise[0] * rise[0] + rise[1] * rise[1]).sqrt();

        // Nothing is higher than the map's depths reach.
        let run = (F32s::splat(REACH_TEXELS) * width).most(F32s::splat(1.5) * rise_length).least(one / depth_scale);
        // The receiver's own caster deviates along the normal, and light grazes at a cosine of at least 0.1. Positions
        // are rounded, and so are the map's depths, up to 1.
        let facets = rise_of_facets(width, cosine);
        let mesh_error = F32s::splat(*mesh_error) / cosine.most(F32s::splat(0.1));
        let rounding = start.x.abs().most(start.y.abs()).most(start.z.abs()) * F32s::splat(1.0 / 2_097_152.0);
        let tolerance = (facets + mesh_error + rounding) * depth_scale + F32s::splat(DEPTH_ROUNDING);
        let most = run * depth_scale;
        StraightReceiver {
            face: U32s::ZERO,
            texel: texel_at(fit_of(&[*fit], U32s::ZERO), [at.x, at.y], side),
            // A plane rises by nothing at the receiver. A sum with -0 changes no bit.
            plane: F32s::splat(-0.0),
            step: [rise[0] * depth_scale, -rise[1] * depth_scale],
            depths: DirectionalDepths { receiver: (at.z - F32s::splat(*bottom)) * depth_scale, most },
            tolerance,
            reach: tolerance.most(most),
            filter: self.map.filter,
            is_steep: rise_length.gt(F32s::splat(GRAZING_TEXELS) * width),
            traced_length: F32s::splat(3.0) * run,
        }
    }
}

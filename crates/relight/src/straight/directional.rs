//! Directional lights, like `parallel.wgsl` and `parallel_lookup.wgsl`. Light space has the light's axes about the
//! scene's origin. Light travels along -z.

use glam::Mat4;
use light::{Lanes, LightProfile, Mask};

use super::{DEPTH_ROUNDING, GRAZING_TEXELS, LightFrame, Located, REACH_TEXELS, no_light, rise_of_facets};
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::shape::{LightSampleLanes, RelitShape};
use crate::surfaces::SurfaceLanes;
use crate::visibility::{
    Facing, LitTexels, Receiver, beyond_map, facing, filter_visibility, fit_of, gathered,
    resolve_along_segment, texel_at,
};
use crate::{CasterScene, ShadowFilter};

/// Directional light as it is drawn.
#[derive(Debug)]
pub struct RelitDirectional {
    frame: LightFrame,
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
    /// Largest deviation of the casters from the surface, in world units.
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
        Self { frame: LightFrame::new(light_from_scene), light_profile, window, map }
    }

    #[inline(always)]
    pub(super) fn locate(&self, scene_position: Vec3s) -> Located {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let position = self.frame.vector(scene_position);
        let [scale_v, scale_w, shift_v, shift_w] = self.window;
        let v = F32s::splat(shift_v) - position.x * F32s::splat(scale_v);
        let w = position.y * F32s::splat(scale_w) + F32s::splat(shift_w);
        let toward = self.frame.scene_vector(Vec3s { x: zero, y: zero, z: one });
        Located { inside: v.abs().le(one) & w.abs().le(one), v, w, s: zero, to_light: toward }
    }
}

impl RelitShape for RelitDirectional {
    fn light_profile(&self) -> &LightProfile {
        &self.light_profile
    }

    #[inline(always)]
    fn sample(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        asked: Masks,
    ) -> LightSampleLanes {
        let mut located = self.locate(surface.position);
        located.inside = located.inside & asked;
        if !located.inside.any() {
            return no_light();
        }
        let visibility = match map {
            Some(map) => self.visibility(scene, map, surface, located.to_light, located.inside),
            None => F32s::splat(1.0),
        };
        located.sample(&self.light_profile, visibility)
    }
}

/// Position of receivers on the map, and the planes that they lie in. Lengths along the light are in units of the map's
/// depth.
struct DirectionalReceiver {
    texel: [F32s; 2],
    depth: F32s,
    /// Rise of a receiver's plane from one texel to the next, to the right and downwards. The plane's rise over all
    /// texels is limited to `most`.
    step: [F32s; 2],
    most: F32s,
    /// Height above a receiver's plane up to which a stored caster does not shadow the receiver. `tolerance` is the
    /// height if the map alone decides. `reach` is the greater height if ray tests against the scene decide about the
    /// casters in between.
    tolerance: F32s,
    reach: F32s,
}

impl Receiver for DirectionalReceiver {
    #[inline(always)]
    fn texel(&self) -> [F32s; 2] {
        self.texel
    }

    #[inline(always)]
    fn lit_texels(&self, map: &DepthMap, first: [F32s; 2]) -> LitTexels {
        let [right, down] = self.step;
        let corner = right * (first[0] - self.texel[0]) + down * (first[1] - self.texel[1]);
        let rises = [corner, corner + right, corner + down, corner + (right + down)];
        let stored = gathered(map, U32s::splat(0), first);
        let beyond = beyond_map(first, map.side());
        let mut lit = LitTexels { resolved: beyond, deferred: beyond };
        for k in 0..4 {
            // An empty texel holds 0, and nothing is below that.
            let plane = (self.depth + rises[k].within(-self.most, self.most)).most(F32s::splat(0.0));
            lit.resolved[k] = lit.resolved[k] | stored[k].le(plane + self.tolerance);
            lit.deferred[k] = lit.deferred[k] | stored[k].le(plane + self.reach);
        }
        lit
    }
}

impl RelitDirectional {
    /// Computes the share of the light that no caster blocks, for the `asked` lanes. The receiver's own plane has a
    /// height at each texel's center, and that height is compared with the texel, so that no plane shadows itself.
    #[inline(always)]
    fn visibility(
        &self,
        scene: &CasterScene,
        map: &DepthMap,
        surface: &SurfaceLanes,
        to_light: Vec3s,
        asked: Masks,
    ) -> F32s {
        let (zero, one) = (F32s::splat(0.0), F32s::splat(1.0));
        let Facing { active: asked, faces_light, normal } = facing(scene, surface, to_light, asked);
        if !asked.any() {
            return zero;
        }
        let start = surface.shadow_position();
        let at = self.frame.vector(start);
        let normal = self.frame.vector(normal);
        let cosine = normal.z.most(F32s::splat(1e-20));
        let place = &self.map;
        let [.., per_x, per_y] = place.fit;
        let (side, depth_scale) = (F32s::splat(map.side() as f32), F32s::splat(place.depth_scale));
        // In world units.
        let texels = [2.0 / (per_x * map.side() as f32), 2.0 / (per_y * map.side() as f32)];
        let width = F32s::splat(texels[0].max(texels[1]));
        let rise = [-normal.x / cosine * F32s::splat(texels[0]), -normal.y / cosine * F32s::splat(texels[1])];
        let rise_length = (rise[0] * rise[0] + rise[1] * rise[1]).sqrt();

        // Nothing is higher than the map's depths reach.
        let run =
            (F32s::splat(REACH_TEXELS) * width).most(F32s::splat(1.5) * rise_length).least(one / depth_scale);
        // The receiver's own caster deviates along the normal, and light grazes at a cosine of at least 0.1. Positions
        // are rounded, and so are the map's depths, up to 1.
        let facets = rise_of_facets(width, cosine);
        let strayed = F32s::splat(place.mesh_error) / cosine.most(F32s::splat(0.1));
        let rounding = start.x.abs().most(start.y.abs()).most(start.z.abs()) * F32s::splat(1.0 / 2_097_152.0);
        let tolerance = (facets + strayed + rounding) * depth_scale + F32s::splat(DEPTH_ROUNDING);
        let most = run * depth_scale;
        let receiver = DirectionalReceiver {
            texel: texel_at(fit_of(&[place.fit], U32s::splat(0)), [at.x, at.y], side),
            depth: (at.z - F32s::splat(place.bottom)) * depth_scale,
            step: [rise[0] * depth_scale, -rise[1] * depth_scale],
            most,
            tolerance,
            reach: tolerance.most(most),
        };
        let shares = filter_visibility(&receiver, map, place.filter);

        // A steep caster beside the receiver may be higher than at it, so the ray test covers twice the reach, and as
        // far as the plane rises in the texels around.
        let grazes = asked & (!faces_light | rise_length.gt(F32s::splat(GRAZING_TEXELS) * width));
        let way = to_light * (F32s::splat(3.0) * run);
        F32s::select(asked, resolve_along_segment(scene, surface, shares, grazes, way), zero)
    }
}

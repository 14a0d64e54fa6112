//! Receivers on the maps of straight lights, and the light that arrives at them.

use light::{Lanes, LightProfile, Mask};

use super::Located;
use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, U32s, Vec3s};
use crate::shape::{LightCoordsLanes, LightSampleLanes, RelitShape, finite_attenuation};
use crate::surfaces::SurfaceLanes;
use crate::visibility::{
    Facing, LitTexels, Receiver, beyond_map, facing, filter_visibility, gathered, resolve_along_segment,
};
use crate::{CasterScene, ShadowFilter};

/// Shape of a straight light.
pub(super) trait StraightShape: Sync {
    type Depths: MapDepths;
    fn profile(&self) -> &LightProfile;
    /// Computes the coordinates of surfaces in the light.
    fn locate(&self, scene_position: Vec3s) -> Located;
    /// Makes the receivers of surfaces, whose planes have the unit normal `normal` in scene space.
    ///
    /// A receiver's own plane has a depth at each texel's center, and that depth is compared with the texel, so that no
    /// plane shadows itself.
    fn receiver(&self, map: &DepthMap, surface: &SurfaceLanes, normal: Vec3s) -> StraightReceiver<Self::Depths>;
}

/// Comparison of a map's depths with the planes of receivers.
pub(super) trait MapDepths {
    /// Returns the lanes in which a texel that stores `stored` leaves a receiver lit whose plane has the value `plane`
    /// there, for both `limits`: [`StraightReceiver::tolerance`] and [`StraightReceiver::reach`].
    fn lit(&self, stored: F32s, plane: F32s, limits: [F32s; 2]) -> [Masks; 2];
}

/// Position of receivers on a map, and the planes that they lie in.
pub(super) struct StraightReceiver<Depths> {
    pub face: U32s,
    pub texel: [F32s; 2],
    /// Value of a receiver's plane at the receiver. It changes by `step` from one texel to the next, to the right and
    /// downwards.
    pub plane: F32s,
    pub step: [F32s; 2],
    pub depths: Depths,
    /// Difference between a caster and a receiver's plane up to which the caster does not shadow the receiver.
    /// `tolerance` is the difference if the map alone decides. `reach` is the greater difference if ray tests against
    /// the scene decide about the casters in between.
    pub tolerance: F32s,
    pub reach: F32s,
    pub filter: ShadowFilter,
    /// Lanes whose planes change so much from one texel to the next that light grazes them.
    pub is_steep: Masks,
    /// Length of the end of the light path that ray tests cover: a steep caster beside the receiver may be nearer than
    /// at it, so twice the reach, and as far as the plane runs in the texels around.
    pub traced_length: F32s,
}

impl<Depths: MapDepths> Receiver for StraightReceiver<Depths> {
    #[inline(always)]
    fn texel(&self) -> [F32s; 2] {
        self.texel
    }

    #[inline(always)]
    fn lit_texels(&self, map: &DepthMap, first: [F32s; 2]) -> LitTexels {
        let [right, down] = self.step;
        let corner = self.plane + (right * (first[0] - self.texel[0]) + down * (first[1] - self.texel[1]));
        let planes = [corner, corner + right, corner + down, corner + (right + down)];
        let stored = gathered(map, self.face, first);
        let beyond = beyond_map(first, map.side());
        let mut lit = LitTexels { resolved: beyond, deferred: beyond };
        for k in 0..4 {
            let [resolved, deferred] = self.depths.lit(stored[k], planes[k], [self.tolerance, self.reach]);
            lit.resolved[k] = lit.resolved[k] | resolved;
            lit.deferred[k] = lit.deferred[k] | deferred;
        }
        lit
    }
}

impl<Shape: StraightShape> RelitShape for Shape {
    fn light_profile(&self) -> &LightProfile {
        self.profile()
    }

    #[inline(always)]
    fn sample(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        active: Masks,
    ) -> LightSampleLanes {
        let mut located = self.locate(surface.position);
        located.inside = located.inside & active;
        if !located.inside.any() {
            return LightSampleLanes::none();
        }
        let visibility = match map {
            Some(map) => visibility(self, scene, map, surface, &located),
            None => F32s::splat(1.0),
        };
        let share = finite_attenuation(self.profile(), located.v, located.w, located.s);
        let irradiance = Vec3s { x: share, y: share, z: share };
        LightSampleLanes { inside: located.inside, direction: located.to_light, irradiance, visibility }
    }

    #[inline(always)]
    fn coords(&self, surface: &SurfaceLanes, active: Masks) -> LightCoordsLanes {
        let Located { inside, t, v, w, to_light, .. } = self.locate(surface.position);
        LightCoordsLanes { inside: inside & active, t, v, w, direction: to_light }
    }
}

/// Computes the share of the light that no caster blocks, for the lanes inside the light.
#[inline(always)]
fn visibility<Shape: StraightShape>(
    shape: &Shape,
    scene: &CasterScene,
    map: &DepthMap,
    surface: &SurfaceLanes,
    located: &Located,
) -> F32s {
    let Facing { active, faces_light, normal } = facing(scene, surface, located.to_light, located.inside);
    if !active.any() {
        return F32s::ZERO;
    }
    let receiver = shape.receiver(map, surface, normal);
    let shares = filter_visibility(&receiver, map, receiver.filter);
    let grazes = active & (!faces_light | receiver.is_steep);
    let end_of_path = located.to_light * receiver.traced_length;
    F32s::select(active, resolve_along_segment(scene, surface, shares, grazes, end_of_path), F32s::ZERO)
}

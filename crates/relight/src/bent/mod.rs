//! BendyLights: coordinates of surfaces in the tube, and their shadows by a bent map. Like `bendy.wgsl`, on the generic
//! light model that `light` has for one lane and for many.

mod casters;
mod edges;
mod lookup;
mod map;
mod root;
mod slab;
mod split;
mod triangles;
mod visibility;
mod wireframe;

use glam::{Mat4, Vec3};
use light::{Curve, Lanes, LightProfile, Mask, Segment, Tube, TubeBox, TubeRoot};

use crate::depth_map::DepthMap;
use crate::lanes::{F32s, Masks, Vec3s};
use crate::shape::{LightCoordsLanes, LightSampleLanes, RelitShape, finite_attenuation};
use crate::surfaces::SurfaceLanes;
use crate::transform::Affine3s;
use crate::{CasterScene, ShadowFilter};

pub use casters::{BentCasters, BentFace, BentMap};
pub use map::BentMapBuilder;
pub use slab::{MapSlab, TubeSpace};
pub use wireframe::Wireframe;

/// Largest color and largest intensity. Their product stays finite.
const MAX_INTENSITY: f32 = 1e15;
/// Largest emission for which the irradiance stays finite through the BRDF.
const MAX_EMISSION: f32 = 1e15;

/// BendyLight, or a part of one, as it is drawn.
#[derive(Debug)]
pub struct RelitBent {
    tube: Tube<F32s>,
    tube_from_scene: Affine3s,
    /// Rotation from tube axes to world axes.
    world_from_tube: Affine3s,
    world_per_tube: f32,
    t_of_light: [f32; 2],
    map: BentMapParams,
}

/// Depths and faces of a bent map; see `tube.wgsl`.
#[derive(Clone, Copy, Debug, Default)]
pub struct BentMapParams {
    /// The t of depth 0.
    pub t_base: f32,
    /// Difference in t between the depths 0 and 1.
    pub t_span: f32,
    /// Largest t at which anything casts shadows.
    pub t_last: f32,
    /// Radius over the depth of the map's cube; `None` for a map with one face, linear in v and w.
    pub slope: Option<f32>,
    /// Distance behind the map's depth up to which a receiver is lit, in texels.
    pub tolerance_texels: f32,
    /// Largest distance of the casters, which may be simplified, from the scene's surface, in tube space.
    pub mesh_error: f32,
    /// Center and 1 / half size of the drawn part of each face, as slopes.
    pub fits: [[f32; 4]; 5],
    pub filter: ShadowFilter,
}

impl RelitBent {
    /// Makes a light that is ready to draw. `tube_from_scene` takes scene space to tube space. `t_of_light` has the t of
    /// the whole light where the tube, a part of it, begins, and its change per t of the part.
    pub fn new(tube: &Tube<f64>, tube_from_scene: Mat4, t_of_light: [f64; 2], map: BentMapParams) -> Self {
        Self {
            tube: splat_tube(tube),
            tube_from_scene: Affine3s::splat(tube_from_scene),
            world_from_tube: Affine3s::splat(Mat4::from_mat3(tube.placement.rotation.as_mat3())),
            world_per_tube: tube.placement.world_per_tube as f32,
            t_of_light: t_of_light.map(|t| t as f32),
            map,
        }
    }
}

impl RelitShape for RelitBent {
    fn light_profile(&self) -> &LightProfile {
        &self.tube.light_profile
    }

    #[inline(always)]
    fn sample(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        active: Masks,
    ) -> LightSampleLanes {
        let q = self.tube_from_scene.position(surface.position);
        let nearest = root::nearest(&self.tube, q, active);
        let mut sample = LightSampleLanes { inside: nearest.found, ..LightSampleLanes::none() };
        // Sixteen neighbouring pixels mostly lie in one segment.
        for segment in 0..self.tube.segments.len() {
            let here = nearest.found & nearest.segment.equals(F32s::splat(segment as f32));
            if here.any() {
                let (inside, _) = self.tube.inside_at(segment, q, nearest.u);
                let of_segment = self.sample_at(scene, map, surface, &self.tube.root_at(&inside), here);
                sample.direction = F32s::select_vec(here, of_segment.direction, sample.direction);
                sample.irradiance = F32s::select_vec(here, of_segment.irradiance, sample.irradiance);
                sample.visibility = F32s::select(here, of_segment.visibility, sample.visibility);
            }
        }
        sample
    }

    #[inline(always)]
    fn coords(&self, surface: &SurfaceLanes, active: Masks) -> LightCoordsLanes {
        let (zero, one) = (F32s::ZERO, F32s::splat(1.0));
        let q = self.tube_from_scene.position(surface.position);
        let nearest = root::nearest(&self.tube, q, active);
        let [start, span] = self.t_of_light.map(F32s::splat);
        let t = start + span * (nearest.segment + nearest.u);
        let nowhere = Vec3s::splat([0.0; 3]);
        let mut coords = LightCoordsLanes { inside: nearest.found, t, v: zero, w: zero, direction: nowhere };
        for segment in 0..self.tube.segments.len() {
            let here = nearest.found & nearest.segment.equals(F32s::splat(segment as f32));
            if here.any() {
                let (inside, _) = self.tube.inside_at(segment, q, nearest.u);
                let root = self.tube.root_at(&inside);
                let radius = F32s::select(root.radius.gt(zero), root.radius, one);
                let toward = self.world_from_tube.vector(self.tube.direction_at(&root));
                coords.v = F32s::select(here, root.v_len / radius, coords.v);
                coords.w = F32s::select(here, root.w_len / radius, coords.w);
                let toward = toward * (one / F32s::length(toward));
                coords.direction = F32s::select_vec(here, toward, coords.direction);
            }
        }
        coords
    }
}

impl RelitBent {
    /// Samples the light at roots of one segment, in the `here` lanes.
    #[inline(always)]
    fn sample_at(
        &self,
        scene: &CasterScene,
        map: Option<&DepthMap>,
        surface: &SurfaceLanes,
        root: &TubeRoot<F32s>,
        here: Masks,
    ) -> LightSampleLanes {
        let one = F32s::splat(1.0);
        let radius = F32s::select(root.radius.gt(F32s::ZERO), root.radius, one);
        let (v, w) = (root.v_len / radius, root.w_len / radius);
        let toward = self.world_from_tube.vector(self.tube.direction_at(root));
        let profile = &self.tube.light_profile;
        let s = if profile.needs_distance() { self.tube.path_length(root) } else { F32s::ZERO };
        let most = F32s::splat(MAX_EMISSION);
        let [r, g, b] = F32s::coordinates(self.tube.segments[root.segment].emission(root.u));
        let emission = F32s::vec3([r.least(most), g.least(most), b.least(most)]);
        let share = finite_attenuation(profile, v, w, s);
        let visibility = match map {
            Some(map) => self.visibility(scene, map, surface, &self.path(root, v, w), here),
            None => one,
        };
        LightSampleLanes {
            inside: here,
            direction: toward * (one / F32s::length(toward)),
            irradiance: emission * share,
            visibility,
        }
    }
}

/// Makes a tube that has each number of `tube` in all lanes.
pub(crate) fn splat_tube(tube: &Tube<f64>) -> Tube<F32s> {
    let of_tube = Tube::<f32>::from(tube);
    let bound = |x: f32| F32s::splat(x.clamp(-MAX_INTENSITY, MAX_INTENSITY));
    let segments = of_tube.segments.iter().map(|segment| Segment {
        curve: splat_curve(&segment.curve),
        color: segment.color.map(|color| F32s::vec3(color.to_array().map(bound))),
        intensity: segment.intensity.map(bound),
        arc_start: F32s::splat(segment.arc_start),
    });
    Tube {
        segments: segments.collect(),
        n: of_tube.n,
        placement: of_tube.placement,
        frame: of_tube.frame,
        up: in_lanes_vec(of_tube.up),
        direction: of_tube.direction,
        light_profile: of_tube.light_profile,
    }
}

fn in_lanes_vec(v: Vec3) -> Vec3s {
    Vec3s::splat(v.to_array())
}

/// Makes a curve that has each number of `curve` in all lanes.
pub(crate) fn splat_curve(curve: &Curve<f32>) -> Curve<F32s> {
    let bounds = &curve.bounds;
    Curve {
        b0: in_lanes_vec(curve.b0),
        b2: in_lanes_vec(curve.b2),
        d0: in_lanes_vec(curve.d0),
        d1: in_lanes_vec(curve.d1),
        a: in_lanes_vec(curve.a),
        n_hat: in_lanes_vec(curve.n_hat),
        alpha: F32s::splat(curve.alpha),
        beta: F32s::splat(curve.beta),
        r0: F32s::splat(curve.r0),
        e0: F32s::splat(curve.e0),
        ar: F32s::splat(curve.ar),
        bounds: TubeBox {
            center: in_lanes_vec(bounds.center),
            axes: bounds.axes.map(in_lanes_vec),
            half: bounds.half.map(F32s::splat),
        },
    }
}

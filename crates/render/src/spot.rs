//! A spotlight drawn by its own perspective matrix. It shares no code with bent lights, so that each can test
//! the other.

use std::sync::Arc;

use glam::{DAffine3, DMat4, DVec3, DVec4};
use light::{Cone, Light, LightFilter, MAX_EXTENT};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, CommandEncoder, Sampler};

use crate::camera::columns;
use crate::gpu_scene::GpuScene;
use crate::lighting::{LightingPass, Variants};
use crate::map_key::MapKey;
use crate::pipeline::{NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM};
use crate::shadow::{ShadowMap, ShadowPass};
use crate::shadow_settings::MapSize;
use crate::spot_faces::{self, Face, FittedFaces};
use crate::{Gpu, ShadowFilter, ShadowSettings, gpu_structs, shaders};

/// Group 2 of a spotlight's lighting pass; see `spot.wgsl`.
const BINDINGS: [BindingType; 3] = [UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// Largest emission of a channel: `filter.wgsl` then keeps it, exposure, decay and the BRDF within f32.
const MAX_EMISSION: f64 = 1e30;

/// The near plane of a shadow map that starts inside the scene, as a share of the way to the scene's far end:
/// near enough for a lamp in its shade, far enough for the map's depths to resolve a thousandth of the same
/// way.
const NEAR_SHARE: f64 = 1e-3;

/// A spotlight in place: its numbers for one scene.
#[derive(Clone, Debug)]
pub(crate) struct GpuSpot {
    pub uniform: gpu_structs::Spot,
    /// One a face of the map; `None` where nothing casts shadows.
    pub shadow_views: Vec<Option<gpu_structs::ShadowView>>,
    /// The convex hull of these world positions holds all that is lit.
    pub corners_in_world: [DVec3; 5],
}

impl GpuSpot {
    /// Places a checked light within reach of a scene, to which its map was fitted.
    pub fn new(cone: &Cone, scene: &GpuScene, shadows: &ShadowSettings, fitted: &FittedFaces) -> Self {
        let light_from_scene = light_from_scene(cone, scene.posed.origin_in_world);
        let far = ((cone.translation - scene.posed.origin_in_world).abs() + scene.posed.half_extent).length();

        let FittedFaces { faces, nearest } = fitted;
        let least_distance = (NEAR_SHARE * far).max(f64::MIN_POSITIVE);
        let shadow_near = (0.99 * nearest.min(far)).max(least_distance);
        let view = |face: &Face| {
            let clip_from_scene = clip_from_face(face, shadow_near)
                * DMat4::from_mat3(face.axes)
                * DMat4::from(light_from_scene);
            face.casts.then(|| gpu_structs::ShadowView { clip_from_scene: columns(&clip_from_scene) })
        };
        let mut fits = [[0.0; 4]; gpu_structs::SPOT_FACES];
        for (fit, Face { center, half, .. }) in fits.iter_mut().zip(faces) {
            let scale = half.recip();
            *fit = [center.x, center.y, scale.x, scale.y].map(|x| x as f32);
        }

        let light_filter = LightFilter { least_distance, ..cone.light_filter };
        let end = cone.range.unwrap_or(far);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x * cone.tan_outer, y * cone.tan_outer, -1.0) * end);
        let in_world = |local| cone.translation + cone.rotation * local;
        let [a, b, c, d] = corners.map(in_world);
        Self {
            uniform: gpu_structs::Spot {
                light_from_scene: columns(&DMat4::from(light_from_scene)),
                emission: cone.emission.min(DVec3::splat(MAX_EMISSION)).as_vec3().to_array(),
                tan_outer: cone.tan_outer as f32,
                light_filter: (&light_filter).into(),
                range: cone.range.unwrap_or(0.0).min(2.0 * MAX_EXTENT) as f32,
                shadow_near: shadow_near as f32,
                mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
                pad0: 0.0,
                fits,
            },
            shadow_views: faces.iter().map(view).collect(),
            corners_in_world: [cone.translation, a, b, c, d],
        }
    }
}

/// The faces of a light's map over `scene`.
fn fitted((light, cone): (&Light, &Cone), scene: &GpuScene, shadows: &ShadowSettings) -> FittedFaces {
    let side = f64::from(map_size(light, shadows).side);
    FittedFaces::new(
        light,
        side,
        light_from_scene(cone, scene.posed.origin_in_world),
        (&scene.clusters, shadows.mesh_error),
    )
}

fn light_from_scene(cone: &Cone, scene_origin: DVec3) -> DAffine3 {
    DAffine3 { matrix3: cone.rotation, translation: cone.translation - scene_origin }.inverse()
}

/// Reversed depth that starts at `near` and has no end.
fn clip_from_face(face: &Face, near: f64) -> DMat4 {
    let (scale, shift) = (face.half.recip(), -face.center / face.half);
    DMat4::from_cols(
        DVec4::X * scale.x,
        DVec4::Y * scale.y,
        DVec4::new(shift.x, shift.y, 0.0, 1.0),
        DVec4::new(0.0, 0.0, near, 0.0),
    )
}

/// How large a light's map is.
pub(crate) fn map_size(light: &Light, shadows: &ShadowSettings) -> MapSize {
    shadows.map_size(spot_faces::face_count(light))
}

/// How the lighting pass of a spotlight is compiled: see the constants of `spot_faces.wgsl` and `shadow_filter.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BakedSpot {
    filter: ShadowFilter,
    /// Whether its map has the faces of a cube.
    cube: bool,
}

impl BakedSpot {
    pub fn of(light: &Light, filter: ShadowFilter) -> Self {
        Self { filter, cube: spot_faces::face_count(light) > 1 }
    }

    /// Every value.
    #[cfg(test)]
    pub fn all() -> impl Iterator<Item = Self> {
        ShadowFilter::ALL.into_iter().flat_map(|filter| [false, true].map(|cube| Self { filter, cube }))
    }

    /// `wgsl` with its constants.
    pub fn into_wgsl(self, wgsl: &str) -> String {
        format!("const SHADOW_CUBE = {};\n{}", self.cube, self.filter.into_wgsl(wgsl))
    }
}

/// The pipelines of spotlights, which outlive scenes and lights.
#[derive(Debug)]
pub(crate) struct SpotPass {
    shadow: ShadowPass,
    lighting: Variants<BakedSpot>,
    /// Of the view and the surface, and the light's own.
    group_layouts: [BindGroupLayout; 3],
    sampler: Sampler,
}

/// What is kept of one spotlight from picture to picture.
#[derive(Debug)]
pub(crate) struct SpotSlot {
    map: ShadowMap,
    /// What the map shows, and how it is fitted to that scene.
    shown: Option<(MapKey, FittedFaces)>,
}

impl SpotSlot {
    /// Draws the map anew when it is next asked for.
    pub fn invalidate(&mut self) {
        self.shown = None;
    }

    /// How large its map is.
    pub fn size(&self) -> MapSize {
        self.map.target.size
    }

    /// What its map shows.
    pub fn shows(&self) -> Option<MapKey> {
        self.shown.as_ref().map(|(key, _)| *key)
    }
}

impl SpotPass {
    /// `camera_groups` are those of the view and the surface.
    pub fn new(gpu: &Gpu, camera_groups: [&BindGroupLayout; 2], material_layout: &BindGroupLayout) -> Self {
        let [view, surface] = camera_groups;
        Self {
            shadow: ShadowPass::new(gpu, material_layout),
            lighting: Variants::new(),
            group_layouts: [view.clone(), surface.clone(), gpu.layout("spot", &BINDINGS)],
            sampler: gpu
                .device
                .create_sampler(&wgpu::SamplerDescriptor { label: Some("shadow"), ..Default::default() }),
        }
    }

    /// The pass that is compiled in the way of `baked`.
    pub fn lighting(&self, gpu: &Gpu, baked: BakedSpot) -> Arc<LightingPass> {
        self.lighting.get(baked, || {
            LightingPass::new(gpu, "spot", &baked.into_wgsl(shaders::SPOT), &self.group_layouts.each_ref())
        })
    }

    pub fn slot(&self, gpu: &Gpu, size: MapSize) -> SpotSlot {
        SpotSlot { map: self.shadow.map(gpu, size), shown: None }
    }

    /// Brings `slot` up to date with `light` over `scene`. Returns the light in place, group 2 of its lighting pass
    /// and whether its map was drawn.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        slot: &mut SpotSlot,
        (key, light, cone): (MapKey, &Light, &Cone),
        (scene, shadows): (&GpuScene, &ShadowSettings),
    ) -> (GpuSpot, BindGroup, bool) {
        let kept = slot.shown.take().filter(|(kept, _)| *kept == key);
        let stale = kept.is_none();
        let fitted = kept.map_or_else(|| fitted((light, cone), scene, shadows), |(_, fitted)| fitted);
        let placed = GpuSpot::new(cone, scene, shadows, &fitted);
        let uniform = gpu.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("spot"),
            contents: bytemuck::bytes_of(&placed.uniform),
            usage: BufferUsages::UNIFORM,
        });
        let resources = [
            uniform.as_entire_binding(),
            BindingResource::TextureView(&slot.map.target.all),
            BindingResource::Sampler(&self.sampler),
        ];
        // One a picture: lights that share a map have colours of their own.
        let group = gpu.group("spot", &self.group_layouts[2], &resources);
        if stale {
            self.shadow.draw(gpu, encoder, &slot.map, &placed.shadow_views, scene);
        }
        slot.shown = Some((key, fitted));
        (placed, group, stale)
    }
}

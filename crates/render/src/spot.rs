//! A spotlight drawn by its own perspective matrix. It shares no code with bent lights, so that each can test
//! the other.

use std::sync::OnceLock;

use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};
use light::MAX_EXTENT;
use light::{Decay, SpotLight};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, CommandEncoder, Sampler};

use crate::camera::columns;
use crate::lighting::LightingPass;
use crate::pipeline::{NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM};
use crate::shadow::{ShadowMap, ShadowPass};
use crate::shadow_settings::MapSize;
use crate::spot_faces::{self, Face, FittedFaces};
use crate::staged::StagedScene;
use crate::{Gpu, RenderError, ShadowFilter, ShadowSettings, layout, shaders};

/// Group 2 of a spotlight's lighting pass; see `spot.wgsl`.
const BINDINGS: [BindingType; 3] = [UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// Largest intensity of a channel: with it, decay and the BRDF at their largest, radiance is still finite.
const MAX_INTENSITY: f64 = 1e15;

/// The near plane of a shadow map that starts inside the scene, as a share of the way to the scene's far end:
/// near enough for a lamp in its shade, far enough for the map's depths to resolve a thousandth of the same
/// way.
const NEAR_SHARE: f64 = 1e-3;

/// What a spotlight's shadow map depends on, besides the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shape {
    translation: DVec3,
    rotation: DQuat,
    cone_angle: f64,
}

impl Shape {
    pub fn of(light: &SpotLight) -> Self {
        let light::Transform { translation, rotation, .. } = light.transform;
        Self { translation, rotation, cone_angle: light.cone_angle }
    }
}

/// A spotlight in place: its numbers for one scene.
#[derive(Clone, Debug)]
pub(crate) struct PlacedSpot {
    pub uniform: layout::Spot,
    /// One a face of the map; `None` where nothing casts shadows.
    pub shadow_views: Vec<Option<layout::ShadowView>>,
    /// The convex hull of these world positions holds all that is lit.
    pub corners_in_world: [DVec3; 5],
}

impl PlacedSpot {
    /// Places a checked light within reach of a scene, to which its map was fitted.
    pub fn new(
        light: &SpotLight,
        scene: &StagedScene,
        shadows: &ShadowSettings,
        fitted: &FittedFaces,
    ) -> Self {
        let rotation = DMat3::from_quat(light.transform.rotation.normalize());
        let light_from_scene = light_from_scene(light, scene.origin);
        let far = ((light.transform.translation - scene.origin).abs() + scene.half_extent).length();

        let outer = light.cone_angle.to_radians();
        let inner = outer * (1.0 - light.cone_softness);
        let versine = |angle: f64| 2.0 * (angle / 2.0).sin().powi(2);
        let versine_span = versine(outer) - versine(inner);
        let tan_outer = outer.tan();

        let FittedFaces { faces, nearest } = fitted;
        let least_distance = (NEAR_SHARE * far).max(f64::MIN_POSITIVE);
        let shadow_near = (0.99 * nearest.min(far)).max(least_distance);
        let view = |face: &Face| {
            let clip_from_scene = clip_from_face(face, shadow_near)
                * DMat4::from_mat3(face.axes)
                * DMat4::from(light_from_scene);
            face.casts.then(|| layout::ShadowView { clip_from_scene: columns(&clip_from_scene) })
        };
        let mut fits = [[0.0; 4]; layout::SPOT_FACES];
        for (fit, Face { center, half, .. }) in fits.iter_mut().zip(faces) {
            let scale = half.recip();
            *fit = [center.x, center.y, scale.x, scale.y].map(|x| x as f32);
        }

        // Neither below zero, as in a BendyLight.
        let intensity = light.color.max(DVec3::ZERO) * light.intensity.max(0.0);
        let intensity = intensity.min(DVec3::splat(MAX_INTENSITY));
        let decay = match light.decay {
            Decay::None => [1.0, 0.0, 0.0],
            Decay::Linear => [0.0, 1.0, 0.0],
            Decay::InverseSquare => [0.0, 0.0, 1.0],
        };
        let end = light.range.unwrap_or(far);
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| DVec3::new(x * tan_outer, y * tan_outer, -1.0) * end);
        let in_world = |local| light.transform.translation + rotation * local;
        let [a, b, c, d] = corners.map(in_world);
        Self {
            uniform: layout::Spot {
                light_from_scene: columns(&DMat4::from(light_from_scene)),
                intensity: intensity.as_vec3().to_array(),
                tan_outer: tan_outer as f32,
                decay,
                range: light.range.unwrap_or(0.0).min(2.0 * MAX_EXTENT) as f32,
                versine_outer: versine(outer) as f32,
                inverse_versine_span: if versine_span > 0.0 {
                    versine_span.recip().min(1e30) as f32
                } else {
                    0.0
                },
                shadow_near: shadow_near as f32,
                mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
                least_distance: least_distance as f32,
                pad0: [0.0; 3],
                fits,
            },
            shadow_views: faces.iter().map(view).collect(),
            corners_in_world: [light.transform.translation, a, b, c, d],
        }
    }
}

/// The faces of a light's map over `scene`.
fn fitted(light: &SpotLight, scene: &StagedScene, shadows: &ShadowSettings) -> FittedFaces {
    let side = f64::from(map_size(light, shadows).side);
    FittedFaces::new(
        light,
        side,
        light_from_scene(light, scene.origin),
        (&scene.clusters, shadows.mesh_error),
    )
}

fn light_from_scene(light: &SpotLight, scene_origin: DVec3) -> DAffine3 {
    let matrix3 = DMat3::from_quat(light.transform.rotation.normalize());
    DAffine3 { matrix3, translation: light.transform.translation - scene_origin }.inverse()
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
pub(crate) fn map_size(light: &SpotLight, shadows: &ShadowSettings) -> MapSize {
    shadows.map_size(spot_faces::face_count(light))
}

/// How the lighting pass of a spotlight is compiled: see the constants of `spot_faces.wgsl` and `shadow_filter.wgsl`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BakedSpot {
    filter: ShadowFilter,
    /// Whether its map has the faces of a cube.
    cube: bool,
}

impl BakedSpot {
    /// How many values there are.
    const COUNT: usize = 2 * ShadowFilter::ALL.len();

    pub fn of(light: &SpotLight, filter: ShadowFilter) -> Self {
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
    /// One a way to compile them, when first wanted.
    lighting: [OnceLock<LightingPass>; BakedSpot::COUNT],
    /// Of the view and the surface, and the light's own.
    layouts: [BindGroupLayout; 3],
    sampler: Sampler,
}

/// What is kept of one spotlight from picture to picture.
#[derive(Debug)]
pub(crate) struct SpotSlot {
    map: ShadowMap,
    /// What the map shows: a scene's revision and the light's shape, fitted to that scene.
    map_key: Option<(u64, Shape, FittedFaces)>,
}

impl SpotSlot {
    /// Draws the map anew when it is next asked for.
    pub fn invalidate(&mut self) {
        self.map_key = None;
    }

    /// How large its map is.
    pub fn size(&self) -> MapSize {
        self.map.target.size
    }

    /// Whether its map is that of `light` over the scene of that revision.
    pub fn shows(&self, light: &SpotLight, revision: u64) -> bool {
        self.map_key.as_ref().is_some_and(|(r, shape, _)| (*r, *shape) == (revision, Shape::of(light)))
    }
}

impl SpotPass {
    /// `camera_groups` are those of the view and the surface.
    pub fn new(gpu: &Gpu, camera_groups: [&BindGroupLayout; 2], material_layout: &BindGroupLayout) -> Self {
        let [view, surface] = camera_groups;
        Self {
            shadow: ShadowPass::new(gpu, material_layout),
            lighting: std::array::from_fn(|_| OnceLock::new()),
            layouts: [view.clone(), surface.clone(), gpu.layout("spot", &BINDINGS)],
            sampler: gpu
                .device
                .create_sampler(&wgpu::SamplerDescriptor { label: Some("shadow"), ..Default::default() }),
        }
    }

    /// The pass that is compiled in the way of `baked`.
    pub fn lighting(&self, gpu: &Gpu, baked: BakedSpot) -> &LightingPass {
        let BakedSpot { filter, cube } = baked;
        self.lighting[2 * filter as usize + usize::from(cube)].get_or_init(|| {
            LightingPass::new(gpu, "spot", &baked.into_wgsl(shaders::SPOT), &self.layouts.each_ref())
        })
    }

    pub fn slot(&self, gpu: &Gpu, size: MapSize) -> SpotSlot {
        SpotSlot { map: self.shadow.map(gpu, size), map_key: None }
    }

    /// Brings `slot` up to date with `light` over `scene`. Returns the light in place, group 2 of its lighting pass
    /// and whether its map was drawn.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        slot: &mut SpotSlot,
        light: &SpotLight,
        (scene, shadows): (&StagedScene, &ShadowSettings),
    ) -> Result<(PlacedSpot, BindGroup, bool), RenderError> {
        light::check_spot(light)?;
        let key = (scene.revision, Shape::of(light));
        let kept = slot.map_key.take().filter(|(revision, shape, _)| (*revision, *shape) == key);
        let stale = kept.is_none();
        let fitted = kept.map_or_else(|| fitted(light, scene, shadows), |(.., fitted)| fitted);
        let placed = PlacedSpot::new(light, scene, shadows, &fitted);
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
        let group = gpu.group("spot", &self.layouts[2], &resources);
        if stale {
            self.shadow.draw(gpu, encoder, &slot.map, &placed.shadow_views, scene);
        }
        slot.map_key = Some((key.0, key.1, fitted));
        Ok((placed, group, stale))
    }
}

//! A spotlight drawn by its own perspective matrix. It shares no code with bent lights, so that each can test
//! the other.

use std::sync::OnceLock;

use bendy::{Decay, SpotLight};
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, DVec4};
use scene::MAX_EXTENT;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, CommandEncoder, Sampler};

use crate::camera::columns;
use crate::lighting::LightingPass;
use crate::pipeline::{NON_FILTERING, RAW_TEXTURE, UNIFORM};
use crate::shadow::{ShadowMap, ShadowPass};
use crate::staged::StagedScene;
use crate::{Gpu, RenderError, ShadowFilter, ShadowSettings, layout, shaders};

/// Group 2 of a spotlight's lighting pass; see `spot.wgsl`.
const BINDINGS: [BindingType; 3] = [UNIFORM, RAW_TEXTURE, NON_FILTERING];

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
        let bendy::Transform { translation, rotation, .. } = light.transform;
        Self { translation, rotation, cone_angle: light.cone_angle }
    }
}

/// A spotlight in place: its numbers for one scene.
#[derive(Clone, Debug)]
pub(crate) struct PlacedSpot {
    pub uniform: layout::Spot,
    pub shadow_view: layout::ShadowView,
    /// The convex hull of these world positions holds all that is lit.
    pub corners_in_world: [DVec3; 5],
}

impl PlacedSpot {
    /// Places a checked light within reach of a scene whose bounds reach `half_extent` about `scene_origin`.
    pub fn new(light: &SpotLight, scene_origin: DVec3, half_extent: DVec3, shadows: &ShadowSettings) -> Self {
        let rotation = DMat3::from_quat(light.transform.rotation.normalize());
        let scene_from_light =
            DAffine3 { matrix3: rotation, translation: light.transform.translation - scene_origin };
        let source = scene_from_light.translation;
        let far = (source.abs() + half_extent).length();

        let outer = light.cone_angle.to_radians();
        let inner = outer * (1.0 - light.cone_softness);
        let versine = |angle: f64| 2.0 * (angle / 2.0).sin().powi(2);
        let versine_span = versine(outer) - versine(inner);
        let tan_outer = outer.tan();
        // Two texels around the cone let the filter reach over its edge.
        let shadow_tan = tan_outer * f64::from(shadows.resolution) / f64::from(shadows.resolution - 4);

        // The nearest caster: none is nearer along the axis than the box of the scene, seen in the map's
        // corner.
        let to_box = (source.abs() - half_extent).max(DVec3::ZERO).length();
        let corner_cosine = (1.0 + 2.0 * shadow_tan * shadow_tan).sqrt().recip();
        let shadow_near = (0.99 * to_box * corner_cosine).max(NEAR_SHARE * far).max(f64::MIN_POSITIVE);
        let clip_from_light = DMat4::from_cols(
            DVec4::X / shadow_tan,
            DVec4::Y / shadow_tan,
            DVec4::new(0.0, 0.0, 0.0, -1.0),
            DVec4::new(0.0, 0.0, shadow_near, 0.0),
        );
        let light_from_scene = scene_from_light.inverse();
        let clip_from_scene = clip_from_light * light_from_scene;

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
                shadow_tan: shadow_tan as f32,
                mesh_error: shadows.mesh_error.min(2.0 * MAX_EXTENT) as f32,
                pad0: [0.0; 3],
            },
            shadow_view: layout::ShadowView { clip_from_scene: columns(&clip_from_scene) },
            corners_in_world: [light.transform.translation, a, b, c, d],
        }
    }
}

/// The pipelines of spotlights, which outlive scenes and lights.
#[derive(Debug)]
pub(crate) struct SpotPass {
    shadow: ShadowPass,
    /// One a filter, compiled when first wanted.
    lighting: [OnceLock<LightingPass>; ShadowFilter::ALL.len()],
    /// Of the view and the surface, and the light's own.
    layouts: [BindGroupLayout; 3],
    sampler: Sampler,
}

/// What is kept of one spotlight from picture to picture.
#[derive(Debug)]
pub(crate) struct SpotSlot {
    map: ShadowMap,
    /// What the map shows: a scene's revision and the light's shape.
    map_key: Option<(u64, Shape)>,
}

impl SpotSlot {
    /// Draws the map anew when it is next asked for.
    pub fn invalidate(&mut self) {
        self.map_key = None;
    }

    /// Whether its map is that of `light` over the scene of that revision.
    pub fn shows(&self, light: &SpotLight, revision: u64) -> bool {
        self.map_key == Some((revision, Shape::of(light)))
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

    /// The pass whose shadows are blended by `filter`.
    pub fn lighting(&self, gpu: &Gpu, filter: ShadowFilter) -> &LightingPass {
        self.lighting[filter as usize].get_or_init(|| {
            LightingPass::new(gpu, "spot", &filter.into_wgsl(shaders::SPOT), &self.layouts.each_ref())
        })
    }

    pub fn slot(&self, gpu: &Gpu, shadows: &ShadowSettings) -> SpotSlot {
        SpotSlot { map: self.shadow.map(gpu, shadows.resolution), map_key: None }
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
        bendy::check_spot(light)?;
        let placed = PlacedSpot::new(light, scene.origin, scene.half_extent, shadows);
        let uniform = gpu.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("spot"),
            contents: bytemuck::bytes_of(&placed.uniform),
            usage: BufferUsages::UNIFORM,
        });
        let resources = [
            uniform.as_entire_binding(),
            BindingResource::TextureView(&slot.map.depth),
            BindingResource::Sampler(&self.sampler),
        ];
        // One a picture: lights that share a map have colours of their own.
        let group = gpu.group("spot", &self.layouts[2], &resources);
        let key = Some((scene.revision, Shape::of(light)));
        let stale = slot.map_key != key;
        if stale {
            self.shadow.draw(gpu, encoder, &slot.map, &placed.shadow_view, scene);
            slot.map_key = key;
        }
        Ok((placed, group, stale))
    }
}

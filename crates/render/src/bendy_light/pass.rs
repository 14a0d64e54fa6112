//! Lighting pass of a BendyLight, and the data cached for each light between pictures.

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use light::{CheckedLight, Light, LightDigest, Tube};
use scene::PosedScene;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, Sampler, TextureView};

use super::faces::Faces;
use super::fit::BendyFit;
use super::map_shape::MapShape;
use super::shadow::{BentShadowPass, DrawTarget, MapRequest};
use super::shadow_buffers::BentMapBuffers;
use super::wireframe::{WireframePass, WireframeTarget};
use super::{Baked, hull_in_world, segments, t_max, uniform, uniform_with_map};
use crate::casters::CasterSet;
use crate::coarse_casters::SimplifiedCasters;
use crate::gpu_scene::GpuScene;
use crate::lighting::{LightingPass, PassVariants};
use crate::linked::{LinkedCasters, caster_set};
use crate::map_key::MapKey;
use crate::pipeline::{DEPTH_FORMAT, MapTarget, NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM};
use crate::shadow_settings::MapSize;
use crate::{Gpu, RenderError, ShadowSettings, shaders};

/// Group 2 of a BendyLight's lighting pass; see `tube.wgsl` and `bendy.wgsl`.
const BINDINGS: [BindingType; 4] = [UNIFORM, UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// Pipelines for BendyLights: their shadow maps, their lighting and the wireframe. All scenes and lights share them.
#[derive(Debug)]
pub(crate) struct BendyPass {
    shadow: BentShadowPass,
    wireframe: OnceLock<WireframePass>,
    lighting: PassVariants<Baked>,
    /// Layouts of the view, the surface, the light and the links.
    group_layouts: [BindGroupLayout; 4],
    sampler: Sampler,
}

/// Cached shadow map and uniforms of one BendyLight.
#[derive(Debug)]
pub(crate) struct BendySlot {
    target: MapTarget,
    /// Key of the map, and its shape; the shape is `None` if the light casts no shadows.
    map: Option<(MapKey, Option<MapShape>)>,
    /// Cached bind groups of the light, with the scene revision and the light's digest that they were made from.
    placed: Option<(u64, LightDigest, GpuBendy)>,
}

#[derive(Clone, Debug)]
pub(crate) struct GpuBendy {
    /// Compiled-in values, which select the lighting pass.
    pub baked: Baked,
    /// Group 2 of the light's lighting pass.
    pub group: BindGroup,
}

/// Returns the world positions whose convex hull contains everything that a light can light in a scene.
pub(crate) fn corners_in_world(tube: &Tube<f64>, posed: &PosedScene) -> Vec<DVec3> {
    let part = tube.part_near(posed.origin_in_world, posed.half_extent);
    hull_in_world(&part.tube, t_max(&part.tube, posed.origin_in_world, posed.half_extent))
}

impl BendySlot {
    /// Drops the map and the placed light.
    pub fn invalidate(&mut self) {
        (self.map, self.placed) = (None, None);
    }

    pub fn map_key(&self) -> Option<MapKey> {
        self.map.map(|(key, _)| key)
    }

    pub fn size(&self) -> MapSize {
        self.target.size
    }
}

/// Fits a map to the casters in a light: those that `linked` leaves, or the `coarse` ones if they are accurate enough.
pub(super) fn fit_bent_map<'a>(
    gpu: &Gpu,
    (tube, light): (&Tube<f64>, &Light),
    (scene, linked, shadows): (&'a GpuScene, Option<&'a LinkedCasters>, &ShadowSettings),
    coarse: Option<&'a SimplifiedCasters>,
) -> Result<(CasterSet<'a>, MapShape), RenderError> {
    let t_max = t_max(tube, scene.posed.origin_in_world, scene.posed.half_extent);
    let of = (tube, Faces::of(light), t_max);
    let mut casting = caster_set(gpu, scene, linked, shadows.mesh_error)?;
    let mut map = map_shape(of, (scene, &casting), shadows);
    if let Some(SimplifiedCasters { casters, mesh_error, .. }) =
        coarse.filter(|coarse| coarse.is_accurate_for(map.last_texel_in_world(tube)))
    {
        casting.casters = casters;
        let shadows = ShadowSettings { mesh_error: *mesh_error, ..*shadows };
        map = map_shape(of, (scene, &casting), &shadows);
    }
    Ok((casting, map))
}

/// Returns the shape of a light's map over `scene`, fitted to its casters. An extended light ends at `t_max`.
fn map_shape(
    light: (&Tube<f64>, Faces, f64),
    (scene, casting): (&GpuScene, &CasterSet),
    shadows: &ShadowSettings,
) -> MapShape {
    let fit = BendyFit::new(light, scene.posed.origin_in_world, &casting.casters.clusters, shadows.culling);
    MapShape::new(fit, shadows.map_size(light.1.count()).side, shadows.mesh_error)
}

impl BendyPass {
    /// Compiles the pipelines. `camera_groups` are the layouts of the view and the surface.
    pub fn new(gpu: &Gpu, camera_groups: [&BindGroupLayout; 2], links: &BindGroupLayout) -> Self {
        let ([view, surface], own) = (camera_groups, gpu.bind_group_layout("bendy", &BINDINGS));
        Self {
            shadow: BentShadowPass::new(gpu),
            wireframe: OnceLock::new(),
            lighting: PassVariants::new(),
            group_layouts: [view.clone(), surface.clone(), own, links.clone()],
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("bent shadow"),
                ..Default::default()
            }),
        }
    }

    /// Returns the pass for lights with the values `baked`, with shadow links if `linked`.
    pub fn lighting(&self, gpu: &Gpu, baked: Baked, linked: bool) -> Arc<LightingPass> {
        self.lighting.get(baked, linked, || {
            let wgsl = baked.into_wgsl(shaders::BENDY);
            LightingPass::of_light(gpu, "bendy", &wgsl, linked, self.group_layouts.each_ref())
        })
    }

    pub fn slot(gpu: &Gpu, size: MapSize) -> BendySlot {
        BendySlot { target: gpu.map_target("bent shadow map", size), map: None, placed: None }
    }

    /// Updates `slot` for `light` over `scene`. Returns the placed light, and true if its map was drawn: with the
    /// casters that `linked` leaves, or with the `coarse` ones if they are accurate enough.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        work: &mut BentMapBuffers,
        slot: &mut BendySlot,
        (key, light, tube): (MapKey, &CheckedLight, &Tube<f64>),
        (scene, linked, shadows): (&GpuScene, Option<&LinkedCasters>, &ShadowSettings),
        coarse: Option<&SimplifiedCasters>,
    ) -> Result<(GpuBendy, bool), RenderError> {
        let revision_of_picture = light.revisions().picture;
        if let Some((revision, same, placed)) = &slot.placed
            && (*revision, *same) == (scene.revision, revision_of_picture)
        {
            return Ok((placed.clone(), false));
        }
        // Uses the part inside the scene: f32 cannot hold both a light far longer than the scene and that part.
        let part = tube.part_near(scene.posed.origin_in_world, scene.posed.half_extent);
        let tube = &part.tube;
        let kept = slot.map.take().filter(|(kept, _)| *kept == key);
        let stale = kept.is_none() && tube.light_profile.shadow_enable;
        let map = if stale {
            let (casting, map) = fit_bent_map(gpu, (tube, light.light()), (scene, linked, shadows), coarse)?;
            let onto = DrawTarget::Map(&slot.target);
            self.shadow.render(gpu, work, &MapRequest { scene, casting, tube, map: &map, onto, shadows })?;
            Some(map)
        } else {
            kept.and_then(|(_, map)| map)
        };
        slot.map = Some((key, map));
        let init = |label, contents: &[u8], usage| {
            gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let origin = scene.posed.origin_in_world;
        let uniform = match &map {
            Some(map) => uniform_with_map(&part, origin, map, shadows),
            None => uniform(&part, origin),
        };
        let uniform = init("bendy", bytemuck::bytes_of(&uniform), BufferUsages::UNIFORM);
        let segments = init("segments", bytemuck::cast_slice(&segments(tube)), BufferUsages::UNIFORM);
        let resources = [
            uniform.as_entire_binding(),
            segments.as_entire_binding(),
            BindingResource::TextureView(&slot.target.all),
            BindingResource::Sampler(&self.sampler),
        ];
        let group = gpu.bind_group("bendy", &self.group_layouts[2], &resources);
        let is_cube = map.as_ref().is_some_and(MapShape::is_cube);
        let placed = GpuBendy { baked: Baked::of(tube, is_cube, shadows.filter), group };
        slot.placed = Some((scene.revision, revision_of_picture, placed.clone()));
        Ok((placed, stale))
    }

    /// Draws the triangles of `light`'s map over `scene` into a picture of `size` pixels.
    pub fn draw_wireframe(
        &self,
        gpu: &Gpu,
        work: &mut BentMapBuffers,
        (light, tube): (&Light, &Tube<f64>),
        (scene, linked, shadows): (&GpuScene, Option<&LinkedCasters>, &ShadowSettings),
        (color, size): (&TextureView, [u32; 2]),
    ) -> Result<(), RenderError> {
        let part = tube.part_near(scene.posed.origin_in_world, scene.posed.half_extent);
        let tube = &part.tube;
        let t_max = t_max(tube, scene.posed.origin_in_world, scene.posed.half_extent);
        // All casters in the light, including those that its map leaves out.
        let faces = Faces::of(light);
        let casting = caster_set(gpu, scene, linked, shadows.mesh_error)?;
        let fit = BendyFit::whole(faces, &casting.casters.clusters, t_max);
        let map = &MapShape::new(fit, shadows.map_size(faces.count()).side, shadows.mesh_error);
        let depth = gpu.target("wireframe", size[0], size[1], DEPTH_FORMAT);
        let depth = &depth.create_view(&wgpu::TextureViewDescriptor::default());
        let pass = self.wireframe.get_or_init(|| WireframePass::new(gpu));
        let t_of_light = [part.t_start, part.t_span];
        let onto = DrawTarget::Wireframe(WireframeTarget { pass, color, depth, size, t_of_light });
        self.shadow.render(gpu, work, &MapRequest { scene, casting, tube, map, onto, shadows })
    }
}

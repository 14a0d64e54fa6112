//! Lighting pass of a BendyLight, and the data cached for each light between pictures.

use std::sync::OnceLock;

use glam::DVec3;
use light::{CheckedLight, Light, LightDigest, LightRays, Tube};
use scene::PosedScene;
use wgpu::{BindGroup, BindGroupLayout, BindingType, BufferUsages, TextureView};

use super::faces::Faces;
use super::fit::BendyFit;
use super::map_shape::MapShape;
use super::shadow::{BentShadowPass, DrawTarget, MapRequest};
use super::shadow_buffers::BentMapBuffers;
use super::wireframe::{WireframePass, WireframeTarget};
use super::{Baked, segments, t_max, uniform, uniform_with_map};
use crate::casters::{CasterSet, Casters};
use crate::coarse_casters::SimplifiedCasters;
use crate::lighting::{LightConstants, LightPasses};
use crate::linked::CasterSource;
use crate::map_key::MapKey;
use crate::pipeline::{DEPTH_FORMAT, MapTarget, NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM, whole_view};
use crate::shadow_settings::MapSize;
use crate::{Gpu, RenderError, shaders};

/// Group 2 of a BendyLight's lighting pass; see `tube.wgsl` and `bendy.wgsl`.
const BINDINGS: [BindingType; 4] = [UNIFORM, UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// Pipelines for BendyLights: their shadow maps, their lighting and the wireframe. All scenes and lights share them.
#[derive(Debug)]
pub(crate) struct BendyPass {
    shadow: BentShadowPass,
    wireframe: OnceLock<WireframePass>,
    pub lighting: LightPasses<Baked>,
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
    let slabs = light::slabs(&part.tube, t_max(&part.tube, posed.origin_in_world, posed.half_extent), 0.0);
    let corners = slabs.iter().flat_map(|slab| slab.slab_curve.bounds.corners());
    corners.map(|corner| part.tube.placement.world_from_tube(corner)).collect()
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

/// Fits a map to the casters in a light: those of the source, or its coarse ones if they are accurate enough.
pub(super) fn fit_bent_map<'a>(
    gpu: &Gpu,
    tube: &Tube<f64>,
    light: &Light,
    source: CasterSource<'a>,
) -> Result<(CasterSet<'a>, MapShape), RenderError> {
    let CasterSource { scene, shadows, coarse, .. } = source;
    let (origin, faces) = (scene.posed.origin_in_world, Faces::of(light));
    let t_max = t_max(tube, origin, scene.posed.half_extent);
    let shape = |casters: &Casters, mesh_error| {
        let fit = BendyFit::new(tube, faces, t_max, origin, &casters.clusters, shadows.culling);
        MapShape::new(fit, shadows.map_size(faces.count()).side, mesh_error)
    };
    let mut casting = source.caster_set(gpu)?;
    let mut map = shape(casting.casters, shadows.mesh_error);
    if let Some(SimplifiedCasters { casters, mesh_error, .. }) =
        coarse.filter(|coarse| coarse.is_accurate_for(map.last_texel_in_world(tube)))
    {
        casting.casters = casters;
        map = shape(casters, *mesh_error);
    }
    Ok((casting, map))
}

impl LightConstants for Baked {
    fn wgsl(self) -> (&'static str, String) {
        ("bendy", self.into_wgsl(shaders::BENDY))
    }
}

impl BendyPass {
    /// Compiles the pipelines. `camera_groups` are the layouts of the view and the surface.
    pub fn new(gpu: &Gpu, camera_groups: [&BindGroupLayout; 2], links: &BindGroupLayout) -> Self {
        Self {
            shadow: BentShadowPass::new(gpu),
            wireframe: OnceLock::new(),
            lighting: LightPasses::new(gpu, "bendy", &BINDINGS, camera_groups, links),
        }
    }

    pub fn slot(gpu: &Gpu, size: MapSize) -> BendySlot {
        BendySlot { target: gpu.map_target("bent shadow map", size), map: None, placed: None }
    }

    /// Updates `slot` for `light`. Returns the placed light, and true if its map was drawn: with the casters of the
    /// source, or with its coarse ones if they are accurate enough.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        work: &mut BentMapBuffers,
        slot: &mut BendySlot,
        key: MapKey,
        light: &CheckedLight,
        source: CasterSource,
    ) -> Result<(GpuBendy, bool), RenderError> {
        let CasterSource { scene, shadows, .. } = source;
        let LightRays::Bent(tube) = light.rays() else { unreachable!("the slot was made for a bent light") };
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
            let (casting, map) = fit_bent_map(gpu, tube, light.light(), source)?;
            let onto = DrawTarget::Map(&slot.target);
            self.shadow.render(gpu, work, &MapRequest { scene, casting, tube, map: &map, onto, shadows })?;
            Some(map)
        } else {
            kept.and_then(|(_, map)| map)
        };
        slot.map = Some((key, map));
        let origin = scene.posed.origin_in_world;
        let uniform = match &map {
            Some(map) => uniform_with_map(&part, origin, map, shadows),
            None => uniform(&part, origin),
        };
        let uniform = gpu.uniform_with("bendy", &uniform);
        let segments = gpu.buffer_with("segments", &segments(tube), BufferUsages::UNIFORM);
        let group = self.lighting.light_group(gpu, &[&uniform, &segments], &slot.target);
        let is_cube = map.as_ref().is_some_and(MapShape::is_cube);
        let placed = GpuBendy { baked: Baked::of(tube, is_cube, shadows.filter), group };
        slot.placed = Some((scene.revision, revision_of_picture, placed.clone()));
        Ok((placed, stale))
    }

    /// Draws the triangles of `light`'s map into a picture.
    pub fn draw_wireframe(
        &self,
        gpu: &Gpu,
        work: &mut BentMapBuffers,
        light: &Light,
        tube: &Tube<f64>,
        source: CasterSource,
        color: &TextureView,
    ) -> Result<(), RenderError> {
        let CasterSource { scene, shadows, .. } = source;
        let part = tube.part_near(scene.posed.origin_in_world, scene.posed.half_extent);
        let tube = &part.tube;
        let t_max = t_max(tube, scene.posed.origin_in_world, scene.posed.half_extent);
        // All casters in the light, including those that its map leaves out.
        let faces = Faces::of(light);
        let casting = source.caster_set(gpu)?;
        let fit = BendyFit::whole(faces, &casting.casters.clusters, t_max);
        let map = &MapShape::new(fit, shadows.map_size(faces.count()).side, shadows.mesh_error);
        let size = [color.texture().width(), color.texture().height()];
        let depth = gpu.target("wireframe", size[0], size[1], DEPTH_FORMAT);
        let depth = &whole_view(&depth);
        let pass = self.wireframe.get_or_init(|| WireframePass::new(gpu));
        let t_of_light = [part.t_start, part.t_span];
        let onto = DrawTarget::Wireframe(WireframeTarget { pass, color, depth, size, t_of_light });
        self.shadow.render(gpu, work, &MapRequest { scene, casting, tube, map, onto, shadows })
    }
}

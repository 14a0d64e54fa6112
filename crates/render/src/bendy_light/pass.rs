//! A BendyLight's lighting pass and what is kept of each light from picture to picture.

use std::sync::OnceLock;

use glam::DVec3;
use light::{BendyLight, EndMode, Frame, Transform, Tube};
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, Sampler, TextureView};

use super::faces::Faces;
use super::fit::Fit;
use super::map_shape::MapShape;
use super::shadow::{BentShadowPass, BentWork, MapRequest, Onto};
use super::wireframe::{Drawing, WireframePass};
use super::{Baked, hull_in_world, segments, t_max, uniform_with_map};
use crate::lighting::LightingPass;
use crate::pipeline::{DEPTH_FORMAT, MapTarget, NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM};
use crate::shadow_settings::MapSize;
use crate::staged::StagedScene;
use crate::{Gpu, RenderError, ShadowSettings, shaders};

/// Group 2 of a BendyLight's lighting pass; see `tube.wgsl` and `bendy.wgsl`.
const BINDINGS: [BindingType; 4] = [UNIFORM, UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// What a bent shadow map depends on, besides the scene.
#[derive(Clone, Debug, PartialEq)]
struct Shape {
    transform: Transform,
    points: Vec<DVec3>,
    radii: Vec<f64>,
    up: DVec3,
    frame: Frame,
    end_mode: EndMode,
}

impl Shape {
    fn of(light: &BendyLight) -> Self {
        Self {
            transform: light.transform,
            points: light.points.clone(),
            radii: light.radii.clone(),
            up: light.up,
            frame: light.frame,
            end_mode: light.end_mode,
        }
    }

    fn is_of(&self, light: &BendyLight) -> bool {
        let Self { transform, points, radii, up, frame, end_mode } = self;
        (transform, points, radii) == (&light.transform, &light.points, &light.radii)
            && (up, frame, end_mode) == (&light.up, &light.frame, &light.end_mode)
    }
}

/// The pipelines, which outlive scenes and lights.
#[derive(Debug)]
pub(crate) struct BendyPass {
    shadow: BentShadowPass,
    /// Compiled when first wanted.
    wireframe: OnceLock<WireframePass>,
    /// Compiled when first wanted, one for each way of evaluating a light, by [`Baked::index`].
    lighting: Box<[OnceLock<LightingPass>]>,
    /// Of the view and the surface, and the light's own.
    layouts: [BindGroupLayout; 3],
    sampler: Sampler,
}

/// What is kept of one BendyLight from picture to picture.
#[derive(Debug)]
pub(crate) struct BendySlot {
    target: MapTarget,
    /// What the map shows: a scene's revision and the light's shape, fitted to that scene.
    map_key: Option<Box<(u64, Shape, MapShape)>>,
    /// The light in place, and of which scene's revision and which light.
    placed: Option<Box<(u64, BendyLight, PlacedBendy)>>,
}

/// A BendyLight in place.
#[derive(Clone, Debug)]
pub(crate) struct PlacedBendy {
    /// Which lighting pass draws it.
    pub baked: Baked,
    /// Group 2 of that pass.
    pub group: BindGroup,
    /// The convex hull of these world positions holds all that is lit.
    pub corners_in_world: Vec<DVec3>,
}

impl BendySlot {
    /// Draws everything anew when it is next asked for.
    pub fn invalidate(&mut self) {
        (self.map_key, self.placed) = (None, None);
    }

    /// Whether its map is that of `light` over the scene of that revision.
    pub fn shows(&self, light: &BendyLight, revision: u64) -> bool {
        self.map_key.as_deref().is_some_and(|(r, shape, _)| *r == revision && shape.is_of(light))
    }

    /// How large its map is.
    pub fn size(&self) -> MapSize {
        self.target.size
    }
}

/// A map of a light over `scene`; where that is extended, up to `t_max`.
fn map_shape(light: (&Tube<f64>, Faces, f64), scene: &StagedScene, shadows: &ShadowSettings) -> MapShape {
    let fit = Fit::new(light, scene.origin, (&scene.clusters, shadows.mesh_error));
    MapShape::new(fit, shadows.map_size(light.1.count()).side)
}

impl BendyPass {
    /// `camera_groups` are those of the view and the surface.
    pub fn new(gpu: &Gpu, camera_groups: [&BindGroupLayout; 2]) -> Self {
        let [view, surface] = camera_groups;
        Self {
            shadow: BentShadowPass::new(gpu),
            wireframe: OnceLock::new(),
            lighting: std::iter::repeat_with(OnceLock::new).take(Baked::COUNT).collect(),
            layouts: [view.clone(), surface.clone(), gpu.layout("bendy", &BINDINGS)],
            sampler: gpu.device.create_sampler(&wgpu::SamplerDescriptor {
                label: Some("bent shadow"),
                ..Default::default()
            }),
        }
    }

    /// The pass that evaluates lights in the way of `baked`.
    pub fn lighting(&self, gpu: &Gpu, baked: Baked) -> &LightingPass {
        self.lighting[baked.index()].get_or_init(|| {
            LightingPass::new(gpu, "bendy", &baked.into_wgsl(shaders::BENDY), &self.layouts.each_ref())
        })
    }

    pub fn slot(gpu: &Gpu, size: MapSize) -> BendySlot {
        BendySlot { target: gpu.map_target("bent shadow map", size), map_key: None, placed: None }
    }

    /// Brings `slot` up to date with `light` over `scene`. Returns the light in place and whether its map was
    /// drawn.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        (work, shadows): (&mut BentWork, &ShadowSettings),
        slot: &mut BendySlot,
        light: &BendyLight,
        scene: &StagedScene,
    ) -> Result<(PlacedBendy, bool), RenderError> {
        if let Some((revision, same, placed)) = slot.placed.as_deref()
            && (*revision, same) == (scene.revision, light)
        {
            return Ok((placed.clone(), false));
        }
        // What lies in the scene: of a light far longer than that, f32 could not hold the whole and the part.
        let part = Tube::new(light)?.part_near(scene.origin, scene.half_extent);
        let tube = &part.tube;
        let t_max = t_max(tube, scene.origin, scene.half_extent);
        let kept = slot.map_key.take().filter(|kept| kept.0 == scene.revision && kept.1.is_of(light));
        let stale = kept.is_none();
        let map = if let Some(kept) = &kept {
            kept.2
        } else {
            let map = map_shape((tube, Faces::of(light), t_max), scene, shadows);
            let (onto, map) = (Onto::Map(&slot.target), &map);
            self.shadow.render(gpu, work, &MapRequest { scene, tube, map, onto, shadows })?;
            *map
        };
        slot.map_key = kept.or_else(|| Some(Box::new((scene.revision, Shape::of(light), map))));
        let init = |label, contents: &[u8], usage| {
            gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let uniform = uniform_with_map(&part, scene.origin, &map, shadows);
        let uniform = init("bendy", bytemuck::bytes_of(&uniform), BufferUsages::UNIFORM);
        let segments = init("segments", bytemuck::cast_slice(&segments(tube)), BufferUsages::UNIFORM);
        let resources = [
            uniform.as_entire_binding(),
            segments.as_entire_binding(),
            BindingResource::TextureView(&slot.target.all),
            BindingResource::Sampler(&self.sampler),
        ];
        let group = gpu.group("bendy", &self.layouts[2], &resources);
        let corners_in_world = hull_in_world(tube, t_max);
        let placed =
            PlacedBendy { baked: Baked::of(tube, map.is_cube(), shadows.filter), group, corners_in_world };
        slot.placed = Some(Box::new((scene.revision, light.clone(), placed.clone())));
        Ok((placed, stale))
    }

    /// Draws the triangles of `light`'s map over `scene` into a picture of `size` pixels.
    pub fn draw_wireframe(
        &self,
        gpu: &Gpu,
        (work, shadows): (&mut BentWork, &ShadowSettings),
        light: &BendyLight,
        scene: &StagedScene,
        (color, size): (&TextureView, [u32; 2]),
    ) -> Result<(), RenderError> {
        let part = Tube::new(light)?.part_near(scene.origin, scene.half_extent);
        let tube = &part.tube;
        let t_max = t_max(tube, scene.origin, scene.half_extent);
        // All that the light meets, what need not be in its map too.
        let faces = Faces::of(light);
        let map = &MapShape::new(Fit::whole(faces, t_max), shadows.map_size(faces.count()).side);
        let depth = gpu.target("wireframe", size[0], size[1], DEPTH_FORMAT);
        let depth = &depth.create_view(&wgpu::TextureViewDescriptor::default());
        let pass = self.wireframe.get_or_init(|| WireframePass::new(gpu));
        let t_of_light = [part.t_start, part.t_span];
        let onto = Onto::Wireframe(Drawing { pass, color, depth, size, t_of_light });
        self.shadow.render(gpu, work, &MapRequest { scene, tube, map, onto, shadows })
    }
}

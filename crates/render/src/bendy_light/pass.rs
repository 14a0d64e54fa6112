//! A BendyLight's lighting pass and what is kept of each light from picture to picture.

use std::sync::OnceLock;

use bendy::{BendyLight, EndMode, Frame, Transform, Tube};
use glam::DVec3;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, Sampler, TextureView};

use super::shadow::{BentShadowPass, BentWork, MapRequest, Onto};
use super::wireframe::{Drawing, WireframePass};
use super::{Baked, hull_in_world, segments, t_max, uniform};
use crate::lighting::LightingPass;
use crate::pipeline::{DEPTH_FORMAT, NON_FILTERING, RAW_TEXTURE, UNIFORM};
use crate::staged::StagedScene;
use crate::{Gpu, RenderError, ShadowSettings, shaders};

/// Group 2 of a BendyLight's lighting pass; see `tube.wgsl` and `bendy.wgsl`.
const BINDINGS: [BindingType; 4] = [UNIFORM, UNIFORM, RAW_TEXTURE, NON_FILTERING];

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
    depth: TextureView,
    /// What the map shows: a scene's revision and the light's shape.
    map_key: Option<(u64, Shape)>,
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
        self.map_key.as_ref().is_some_and(|(r, shape)| *r == revision && shape.is_of(light))
    }
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

    pub fn slot(gpu: &Gpu, shadows: &ShadowSettings) -> BendySlot {
        let side = shadows.resolution;
        let texture = gpu.target("bent shadow map", side, side, DEPTH_FORMAT);
        let depth = texture.create_view(&wgpu::TextureViewDescriptor::default());
        BendySlot { depth, map_key: None, placed: None }
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
        let key = Some((scene.revision, Shape::of(light)));
        let stale = slot.map_key != key;
        if stale {
            let onto = Onto::Map(&slot.depth);
            self.shadow.render(gpu, work, &MapRequest { scene, tube, t_max, onto, shadows })?;
            slot.map_key = key;
        }
        let init = |label, contents: &[u8], usage| {
            gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
        };
        let uniform = uniform(&part, scene.origin, t_max, shadows);
        let uniform = init("bendy", bytemuck::bytes_of(&uniform), BufferUsages::UNIFORM);
        let segments = init("segments", bytemuck::cast_slice(&segments(tube)), BufferUsages::UNIFORM);
        let resources = [
            uniform.as_entire_binding(),
            segments.as_entire_binding(),
            BindingResource::TextureView(&slot.depth),
            BindingResource::Sampler(&self.sampler),
        ];
        let group = gpu.group("bendy", &self.layouts[2], &resources);
        let corners_in_world = hull_in_world(tube, t_max);
        let placed = PlacedBendy { baked: Baked::of(tube, shadows.filter), group, corners_in_world };
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
        let depth = gpu.target("wireframe", size[0], size[1], DEPTH_FORMAT);
        let depth = &depth.create_view(&wgpu::TextureViewDescriptor::default());
        let pass = self.wireframe.get_or_init(|| WireframePass::new(gpu));
        let onto =
            Onto::Wireframe(Drawing { pass, color, depth, size, t_of_light: [part.t_start, part.t_span] });
        self.shadow.render(gpu, work, &MapRequest { scene, tube, t_max, onto, shadows })
    }
}

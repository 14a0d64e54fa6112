//! Lighting pass of a BendyLight, and the drawing of its map.

use std::sync::OnceLock;

use shadow::{MapShape, PlacedBent};
use wgpu::{BindGroup, BindGroupLayout, BindingType, BufferUsages, TextureView};

use super::bent_map::{BentMapPass, DrawTarget, MapRequest};
use super::shadow_buffers::BentMapBuffers;
use super::wireframe::{WireframePass, WireframeTarget};
use super::{Baked, segments, uniform};
use crate::frame::MapSource;
use crate::wgpu::Wgpu;
use crate::wgpu::lighting::{LightConstants, LightPasses};
use crate::wgpu::pipeline::{DEPTH_FORMAT, MapTarget, NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM, whole_view};
use crate::wgpu::shaders;
use crate::{Gpu, RenderError};

/// Group 2 of a BendyLight's lighting pass; see `tube.wgsl` and `bendy.wgsl`.
const BINDINGS: [BindingType; 4] = [UNIFORM, UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// Pipelines for BendyLights: their shadow maps, their lighting and the wireframe. All scenes and lights share them.
#[derive(Debug)]
pub(crate) struct BendyPass {
    map: BentMapPass,
    wireframe: OnceLock<WireframePass>,
    pub lighting: LightPasses<Baked>,
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
            map: BentMapPass::new(gpu),
            wireframe: OnceLock::new(),
            lighting: LightPasses::new(gpu, "bendy", &BINDINGS, camera_groups, links),
        }
    }

    /// Draws the map of a light into `target`. `shape` is that of the map.
    pub fn draw_map(
        &self,
        gpu: &Gpu,
        work: &mut BentMapBuffers,
        placed: &PlacedBent,
        shape: &MapShape,
        source: &MapSource<Wgpu>,
        target: &MapTarget,
    ) -> Result<(), RenderError> {
        self.map.render(gpu, work, &MapRequest { source, placed, shape, onto: DrawTarget::Map(target) })
    }

    /// Makes group 2 of the lighting pass of a light with its map.
    pub fn light_group(&self, gpu: &Gpu, placed: &PlacedBent, map: &MapTarget) -> BindGroup {
        let uniform = gpu.uniform_with("bendy", &uniform(placed));
        let segments = gpu.buffer_with("segments", &segments(&placed.part.tube), BufferUsages::UNIFORM);
        self.lighting.light_group(gpu, &[&uniform, &segments], map)
    }

    /// Draws the triangles of a light's map into a picture. `shape` is that of the map.
    pub fn draw_wireframe(
        &self,
        gpu: &Gpu,
        work: &mut BentMapBuffers,
        placed: &PlacedBent,
        shape: &MapShape,
        source: &MapSource<Wgpu>,
        color: &TextureView,
    ) -> Result<(), RenderError> {
        let size = [color.texture().width(), color.texture().height()];
        let depth = gpu.target("wireframe", size[0], size[1], DEPTH_FORMAT);
        let depth = &whole_view(&depth);
        let pass = self.wireframe.get_or_init(|| WireframePass::new(gpu));
        let t_of_light = [placed.part.t_start, placed.part.t_span];
        let onto = DrawTarget::Wireframe(WireframeTarget { pass, color, depth, size, t_of_light });
        self.map.render(gpu, work, &MapRequest { source, placed, shape, onto })
    }
}

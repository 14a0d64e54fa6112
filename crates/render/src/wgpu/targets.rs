//! Surfaces and light of a view or a tile on the GPU.

use std::sync::OnceLock;

use wgpu::{BindGroup, CommandEncoder, RenderPass, Texture, TextureView};

use super::display::{self, ExposedRadiance};
use super::gbuffer::{self, GbufferTextures};
use super::lighting;
use super::passes::Passes;
use super::pipeline::{color_attachment, whole_view};
use crate::Gpu;
use crate::frame::tile::pixel_count;

/// Bytes per pixel of radiance and of a screen's picture.
const LIT_BYTES_PER_PIXEL: u64 = 16 + 4;

/// Textures of a view or a tile, each created at first use.
#[derive(Debug)]
pub(crate) struct WgpuTargets {
    /// Width and height in pixels.
    pub size: [u32; 2],
    gbuffer: OnceLock<GbufferTextures>,
    lit: OnceLock<LitTargets>,
}

/// Textures to which light is added, and from which a screen's picture is drawn.
#[derive(Debug)]
pub(crate) struct LitTargets {
    pub radiance: Texture,
    pub radiance_view: TextureView,
    pub exposed: ExposedRadiance,
    pub display: Texture,
    pub display_view: TextureView,
}

impl LitTargets {
    fn new(gpu: &Gpu, passes: &Passes, [width, height]: [u32; 2]) -> Self {
        let radiance = gpu.target("radiance", width, height, lighting::FORMAT);
        let radiance_view = whole_view(&radiance);
        let display = gpu.target("display", width, height, display::FORMAT);
        Self {
            exposed: passes.display.bind_radiance(gpu, &radiance_view),
            radiance,
            radiance_view,
            display_view: whole_view(&display),
            display,
        }
    }
}

impl WgpuTargets {
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, gbuffer: OnceLock::new(), lit: OnceLock::new() }
    }

    /// Returns the largest number of bytes of targets of `size` pixels.
    pub fn max_bytes(size: [u32; 2]) -> u64 {
        pixel_count(size) * (gbuffer::BYTES_PER_PIXEL + LIT_BYTES_PER_PIXEL)
    }

    /// Returns the bytes of the textures.
    pub fn bytes(&self) -> u64 {
        let lit = if self.lit.get().is_some() { LIT_BYTES_PER_PIXEL } else { 0 };
        let gbuffer = if self.gbuffer.get().is_some() { gbuffer::BYTES_PER_PIXEL } else { 0 };
        pixel_count(self.size) * (gbuffer + lit)
    }

    pub fn gbuffer(&self, gpu: &Gpu, passes: &Passes) -> &GbufferTextures {
        let [width, height] = self.size;
        self.gbuffer.get_or_init(|| passes.gbuffer.targets(gpu, width, height))
    }

    pub fn lit(&self, gpu: &Gpu, passes: &Passes) -> &LitTargets {
        self.lit.get_or_init(|| LitTargets::new(gpu, passes, self.size))
    }

    /// Begins a pass that adds to the radiance, or to zero if `clears`. `view` is group 0; see `view.wgsl`.
    pub fn begin_lighting<'e>(
        &self,
        gpu: &Gpu,
        passes: &Passes,
        encoder: &'e mut CommandEncoder,
        view: Option<&BindGroup>,
        clears: bool,
    ) -> RenderPass<'e> {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("lighting"),
            color_attachments: &[Some(color_attachment(&self.lit(gpu, passes).radiance_view, clears))],
            ..Default::default()
        });
        pass.set_bind_group(0, view, &[]);
        pass.set_bind_group(1, &self.gbuffer(gpu, passes).surface, &[]);
        pass
    }
}

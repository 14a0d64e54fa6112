//! G-buffer: the surface of each pixel, from the one pass over the scene's triangles that a picture needs.

use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, CommandEncoder, RenderPass, RenderPipeline, TextureFormat, TextureView,
};

use super::material::MaterialDraw;
use super::pipeline::{
    DEPTH_FORMAT, DrawPipeline, INFINITELY_FAR, RAW_TEXTURE, UINT_TEXTURE, color_attachment, cut_into_parts,
    depth_attachment, reversed_depth_test, vertex_buffers, whole_view,
};
use super::scene::part_count;
use super::shaders;
use crate::frame::shared_scene::FrameScene;
use crate::frame::tile::{Tile, pixel_count};
use crate::wgpu::Wgpu;
use crate::{Gpu, RenderError};

const FORMAT: TextureFormat = TextureFormat::Rgba32Uint;
const OFFSET_FORMAT: TextureFormat = TextureFormat::R32Float;

/// Pixels per submission to a software driver, which takes about 10 ms for them.
const BAND_PIXELS: u32 = 1 << 18;
/// Divisor of the number of rows in a band. Pixels that share a texture's level of detail are then in one band.
const BAND_STEP: u32 = 16;

/// Bytes per pixel of a G-buffer: the packed surface, the offset and the depth.
pub(crate) const BYTES_PER_PIXEL: u64 = 16 + 4 + 4;

/// Pipelines that draw the G-buffer. All scenes and pictures share them.
#[derive(Debug)]
pub(crate) struct GbufferPass {
    /// Indexed by flags of the material: color texture, metallic-roughness texture, alpha test, double-sided.
    pipelines: [[[[RenderPipeline; 2]; 2]; 2]; 2],
    /// Group 1 of the lighting passes; see `surface.wgsl`.
    pub surface_layout: BindGroupLayout,
}

/// G-buffer of a picture: its textures, and the bind group by which passes read them.
#[derive(Debug)]
pub(crate) struct GbufferTextures {
    packed: TextureView,
    /// Distance in front of the surface at which its shadow is tested.
    offset: TextureView,
    depth: TextureView,
    /// Group 1 of the lighting passes.
    pub surface: BindGroup,
}

/// Part of a picture of a scene.
#[derive(Clone, Copy)]
pub(crate) struct GbufferView<'a> {
    /// Group 0; see `view.wgsl`.
    pub group: &'a BindGroup,
    pub scene: &'a FrameScene<Wgpu>,
    /// Size of the whole picture in pixels.
    pub size: [u32; 2],
    pub tile: Tile,
}

impl GbufferPass {
    pub fn new(gpu: &Gpu, view_layout: &BindGroupLayout, material_layout: &BindGroupLayout) -> Self {
        let layout = gpu.pipeline_layout("gbuffer", &[view_layout, material_layout]);
        let module = gpu.shader_module("gbuffer", shaders::GBUFFER);
        let pipeline = |[is_colored, is_shiny, is_tested]: [f64; 3], cull_mode| {
            gpu.draw_pipeline(DrawPipeline {
                layout: Some(&layout),
                constants: &[("is_colored", is_colored), ("is_shiny", is_shiny), ("is_tested", is_tested)],
                vertex_buffers: &vertex_buffers()[..1],
                cull_mode,
                depth_stencil: Some(reversed_depth_test()),
                targets: &[Some(FORMAT.into()), Some(OFFSET_FORMAT.into())],
                ..DrawPipeline::new("gbuffer", &module, "vs_gbuffer", Some("fs_gbuffer"))
            })
        };
        Self {
            pipelines: [0.0, 1.0].map(|is_colored| {
                [0.0, 1.0].map(|is_shiny| {
                    [0.0, 1.0].map(|is_tested| {
                        [Some(wgpu::Face::Back), None].map(|culled| pipeline([is_colored, is_shiny, is_tested], culled))
                    })
                })
            }),
            surface_layout: gpu.bind_group_layout("surface", &[UINT_TEXTURE, RAW_TEXTURE, RAW_TEXTURE]),
        }
    }

    pub fn targets(&self, gpu: &Gpu, width: u32, height: u32) -> GbufferTextures {
        let [packed, offset, depth] = [FORMAT, OFFSET_FORMAT, DEPTH_FORMAT]
            .map(|format| whole_view(&gpu.target("gbuffer", width, height, format)));
        let resources = [&packed, &depth, &offset].map(BindingResource::TextureView);
        let surface = gpu.bind_group("surface", &self.surface_layout, &resources);
        GbufferTextures { packed, offset, depth, surface }
    }

    /// Draws the surfaces of the pixels of the tile. The projection covers the whole picture, and pixels outside the tile are clipped, so tiles have the same content as the whole. A software driver draws in
    /// bands of rows. Scenes with a great depth complexity are drawn in parts of the triangles. It yields after each.
    pub fn draw(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        into: &GbufferTextures,
        shown: GbufferView,
    ) -> Result<(), RenderError> {
        let GbufferView { scene, tile, .. } = shown;
        // The cost of a band includes all triangles, each about that of a pixel.
        let least_pixels = BAND_PIXELS.max(scene.triangle_count);
        let rows = (least_pixels / tile.width.max(1)).next_multiple_of(BAND_STEP).max(BAND_STEP);
        let rows = if gpu.is_cpu() { rows.min(tile.height) } else { tile.height };
        for first in (0..tile.height).step_by(rows as usize) {
            let band = [first, rows.min(tile.height - first)];
            let is_whole = band[1] == tile.height;
            self.draw_band(gpu, encoder, into, shown, band)?;
            if !is_whole {
                gpu.submit_and_wait(encoder)?;
                gpu.host.yield_point()?;
            }
        }
        Ok(())
    }

    /// Draws `band`, [first row, rows], of a tile. The first band clears the textures.
    fn draw_band(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        into: &GbufferTextures,
        shown: GbufferView,
        band: [u32; 2],
    ) -> Result<(), RenderError> {
        let GbufferView { scene, tile, .. } = shown;
        let parts = part_count(gpu, scene, pixel_count([tile.width, band[1]]));
        let mut pass = begin(encoder, into, shown, band, band[0] == 0);
        let draws = scene.uploaded.draws.iter().map(|draw| (draw, draw.indices.clone()));
        for (draw, indices, ends_part) in cut_into_parts(draws, parts) {
            self.bind(&mut pass, draw);
            let first_triangle = indices.start / 3;
            pass.draw_indexed(indices, 0, first_triangle..first_triangle + 1);
            if ends_part {
                drop(pass);
                gpu.submit_and_wait(encoder)?;
                gpu.host.yield_point()?;
                pass = begin(encoder, into, shown, band, false);
            }
        }
        Ok(())
    }

    fn bind(&self, pass: &mut RenderPass, draw: &MaterialDraw) {
        let [colored, shiny] = draw.has_textures.map(usize::from);
        let [alpha_tested, double_sided] = [draw.is_alpha_tested, draw.double_sided].map(usize::from);
        pass.set_pipeline(&self.pipelines[colored][shiny][alpha_tested][double_sided]);
        pass.set_bind_group(1, &draw.material, &[]);
    }
}

/// Begins a render pass, which clears the textures if `clears`.
fn begin<'e>(
    encoder: &'e mut CommandEncoder,
    into: &GbufferTextures,
    GbufferView { group, scene, size, tile }: GbufferView,
    [first, rows]: [u32; 2],
    clears: bool,
) -> RenderPass<'e> {
    let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
        label: Some("gbuffer"),
        color_attachments: &[&into.packed, &into.offset].map(|target| Some(color_attachment(target, clears))),
        depth_stencil_attachment: Some(depth_attachment(&into.depth, clears.then_some(INFINITELY_FAR))),
        ..Default::default()
    });
    let [left, top, width, height] =
        [-f64::from(tile.x), -f64::from(tile.y), size[0].into(), size[1].into()].map(|x| x as f32);
    pass.set_viewport(left, top, width, height, 0.0, 1.0);
    pass.set_scissor_rect(0, first, tile.width, rows);
    pass.set_bind_group(0, group, &[]);
    pass.set_vertex_buffer(0, scene.uploaded.geometry.positions.slice(..));
    pass.set_index_buffer(scene.uploaded.geometry.indices.slice(..), wgpu::IndexFormat::Uint32);
    pass
}

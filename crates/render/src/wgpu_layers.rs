//! Layers and their sums on the GPU.

use light::LightInstance;
use scene::MapScale;
use wgpu::{BindGroup, CommandEncoder, TextureFormat, TextureView};

use crate::composite::{GpuTerm, GpuTerms};
use crate::layers::LayerPainter;
use crate::lights::{ReadyLight, ShadowMaps};
use crate::passes::DrawContext;
use crate::pipeline::{color_attachment, whole_view};
use crate::stages::FrameStage;
use crate::tile::{area, row_bands};
use crate::wgpu_maps::{WgpuLight, WgpuMaps};
use crate::{RenderError, composite, lighting};

/// Draws layers on the GPU, on the surfaces of a G-buffer.
pub(crate) struct WgpuLayers<'a> {
    pub context: DrawContext<'a>,
    /// G-buffer, as the bind group that lighting passes read.
    pub surface: &'a BindGroup,
    /// In pixels.
    pub size: [u32; 2],
    pub encoder: &'a mut CommandEncoder,
}

impl WgpuLayers<'_> {
    fn texture(&self, format: TextureFormat) -> TextureView {
        let [width, height] = self.size;
        whole_view(&self.context.gpu.target("layer", width, height, format))
    }
}

impl LayerPainter for WgpuLayers<'_> {
    type Layer = TextureView;
    type Sum = TextureView;
    type Light = WgpuLight;
    type Terms = GpuTerms;
    const LAYER_BYTES_PER_PIXEL: u64 = 16;
    const SUM_BYTES_PER_PIXEL: u64 = 8;

    fn ready_light(
        &mut self,
        shadow_maps: &mut ShadowMaps,
        light: &LightInstance,
        scale: MapScale,
    ) -> Result<Option<ReadyLight<WgpuLight>>, RenderError> {
        let DrawContext { gpu, passes, .. } = self.context;
        shadow_maps.ready_light(&mut WgpuMaps { gpu, passes, encoder: self.encoder }, &self.context, light, scale)
    }

    fn draw_layer(
        &mut self,
        light: &ReadyLight<WgpuLight>,
        pixels: [u32; 4],
        over: Option<TextureView>,
    ) -> Result<TextureView, RenderError> {
        let layer = over.unwrap_or_else(|| self.texture(lighting::LAYER_FORMAT));
        let DrawContext { gpu, passes, scene, .. } = self.context;
        let parts = scene.part_count(gpu, area(pixels));
        for (part, is_last) in row_bands(pixels, parts) {
            let clears = part[1] == pixels[1];
            let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("layer"),
                color_attachments: &[Some(color_attachment(&layer, clears))],
                ..Default::default()
            });
            pass.set_bind_group(0, &scene.view, &[]);
            pass.set_bind_group(1, self.surface, &[]);
            light.lighting(gpu, passes).draw_layer(gpu, &mut pass, &light.groups(), part);
            drop(pass);
            if !is_last {
                gpu.submit_and_wait(self.encoder)?;
                gpu.yield_point()?;
            }
        }
        gpu.end_stage(self.encoder, FrameStage::Light)?;
        // A map without room in the budget must be freed before the next one is drawn.
        if light.transient_map.is_some() {
            gpu.submit_and_wait(self.encoder)?;
        }
        Ok(layer)
    }

    fn draw_sum(&mut self, terms: &GpuTerms, over: Option<TextureView>) -> Result<TextureView, RenderError> {
        let sum = over.unwrap_or_else(|| self.texture(composite::SUM_FORMAT));
        self.context.passes.composite.draw_sum(self.encoder, terms, &sum);
        self.context.gpu.end_stage(self.encoder, FrameStage::Sum)?;
        Ok(sum)
    }

    fn terms_of_layers(&self, layers: &[GpuTerm<TextureView>]) -> GpuTerms {
        self.context.passes.composite.layers(self.context.gpu, layers)
    }

    fn terms_of_sums(&self, sums: &[TextureView]) -> GpuTerms {
        self.context.passes.composite.sums(self.context.gpu, sums)
    }

    fn finish(&mut self) -> Result<(), RenderError> {
        self.context.gpu.submit_and_wait(self.encoder)
    }
}

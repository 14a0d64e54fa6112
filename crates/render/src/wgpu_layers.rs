//! Layers and their sums on the GPU.

use light::LightInstance;
use scene::MapScale;
use wgpu::{BindGroup, CommandEncoder, TextureFormat, TextureView, TextureViewDescriptor};

use crate::camera::CameraRaster;
use crate::composite::{GpuTerm, GpuTerms};
use crate::gpu_scene::GpuScene;
use crate::layers::LayerPainter;
use crate::lights::{ReadyLight, ShadowMaps};
use crate::parts::{area, row_bands};
use crate::passes::Passes;
use crate::pipeline::color_attachment;
use crate::stages::FrameStage;
use crate::wgpu_maps::{WgpuLight, WgpuMaps};
use crate::{Gpu, RenderError, composite, lighting};

/// Draws layers on the GPU, on the surfaces of a G-buffer.
pub(crate) struct WgpuLayers<'a> {
    pub gpu: &'a Gpu,
    pub passes: &'a Passes,
    pub scene: &'a GpuScene,
    /// G-buffer, as the bind group that lighting passes read.
    pub surface: &'a BindGroup,
    /// In pixels.
    pub size: [u32; 2],
    pub encoder: &'a mut CommandEncoder,
}

impl WgpuLayers<'_> {
    fn texture(&self, format: TextureFormat) -> TextureView {
        let [width, height] = self.size;
        let texture = self.gpu.target("layer", width, height, format);
        texture.create_view(&TextureViewDescriptor::default())
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
        raster: &CameraRaster,
        light: (&LightInstance, MapScale),
    ) -> Result<Option<ReadyLight<WgpuLight>>, RenderError> {
        let (gpu, passes, scene) = (self.gpu, self.passes, self.scene);
        let mut maps = WgpuMaps { gpu, passes, scene, encoder: self.encoder };
        shadow_maps.ready_light((gpu, &mut maps), (passes, scene, raster), light)
    }

    fn draw_layer(
        &mut self,
        light: &ReadyLight<WgpuLight>,
        pixels: [u32; 4],
        over: Option<TextureView>,
    ) -> Result<TextureView, RenderError> {
        let layer = over.unwrap_or_else(|| self.texture(lighting::LAYER_FORMAT));
        let parts = self.scene.part_count(self.gpu, area(pixels));
        for (part, is_last) in row_bands(pixels, parts) {
            let clears = part[1] == pixels[1];
            let mut pass = self.encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("layer"),
                color_attachments: &[Some(color_attachment(&layer, clears))],
                ..Default::default()
            });
            pass.set_bind_group(0, &self.scene.view, &[]);
            pass.set_bind_group(1, self.surface, &[]);
            light.lighting(self.gpu, self.passes).draw_layer(self.gpu, &mut pass, &light.groups(), part);
            drop(pass);
            if !is_last {
                self.gpu.submit_and_wait(self.encoder)?;
                self.gpu.yield_point()?;
            }
        }
        self.gpu.end_stage(self.encoder, FrameStage::Light)?;
        // A map without room in the budget must be freed before the next one is drawn.
        if light.transient_map.is_some() {
            self.gpu.submit_and_wait(self.encoder)?;
        }
        Ok(layer)
    }

    fn draw_sum(&mut self, terms: &GpuTerms, over: Option<TextureView>) -> Result<TextureView, RenderError> {
        let sum = over.unwrap_or_else(|| self.texture(composite::SUM_FORMAT));
        self.passes.composite.draw_sum(self.encoder, terms, &sum);
        self.gpu.end_stage(self.encoder, FrameStage::Sum)?;
        Ok(sum)
    }

    fn terms_of_layers(&self, layers: &[GpuTerm<TextureView>]) -> GpuTerms {
        self.passes.composite.layers(self.gpu, layers)
    }

    fn terms_of_sums(&self, sums: &[TextureView]) -> GpuTerms {
        self.passes.composite.sums(self.gpu, sums)
    }

    fn finish(&mut self) -> Result<(), RenderError> {
        self.gpu.submit_and_wait(self.encoder)
    }
}

//! Layers and their sums on the CPU.

use std::sync::Arc;

use light::LightInstance;
use relight::{DrawnLight, LayerSum, LightLayer, Surfaces, draw_layer};
use scene::MapScale;

use crate::RenderError;
use crate::composite::GpuTerm;
use crate::host_scene::caster_scene;
use crate::layers::LayerPainter;
use crate::lights::{ReadyLight, ShadowMaps};
use crate::native_map::{NativeLight, NativeMaps};
use crate::passes::DrawContext;
use crate::stages::FrameStage;

/// Draws layers on the CPU, on the surfaces that the pixels show.
pub(crate) struct NativeLayers<'a> {
    pub context: DrawContext<'a>,
    pub surfaces: &'a Surfaces,
}

/// Layers or sums that the native backend adds up.
#[derive(Debug)]
pub(crate) enum NativeTerms {
    Layers(Vec<GpuTerm<Arc<LightLayer>>>),
    Sums(Vec<Arc<LayerSum>>),
}

impl NativeTerms {
    /// Calls `work` with the terms in the form that `relight` takes.
    pub fn with<'a, T>(&'a self, work: impl FnOnce(relight::LayerTerms) -> T) -> T {
        match self {
            Self::Layers(terms) => {
                let of = |GpuTerm { layer, diffuse, specular }: &'a GpuTerm<Arc<LightLayer>>| relight::LayerTerm {
                    layer,
                    diffuse: *diffuse,
                    specular: *specular,
                };
                let terms: Vec<_> = terms.iter().map(of).collect();
                work(relight::LayerTerms::Layers(&terms))
            }
            Self::Sums(sums) => {
                let sums: Vec<&LayerSum> = sums.iter().map(|sum| &**sum).collect();
                work(relight::LayerTerms::Sums(&sums))
            }
        }
    }
}

impl LayerPainter for NativeLayers<'_> {
    type Layer = Arc<LightLayer>;
    type Sum = Arc<LayerSum>;
    type Light = NativeLight;
    type Terms = NativeTerms;
    const LAYER_BYTES_PER_PIXEL: u64 = 24;
    const SUM_BYTES_PER_PIXEL: u64 = 12;

    fn ready_light(
        &mut self,
        shadow_maps: &mut ShadowMaps,
        light: &LightInstance,
        scale: MapScale,
    ) -> Result<Option<ReadyLight<NativeLight>>, RenderError> {
        shadow_maps.ready_light(&mut NativeMaps(self.context.gpu), &self.context, light, scale)
    }

    fn draw_layer(
        &mut self,
        light: &ReadyLight<NativeLight>,
        pixels: [u32; 4],
        over: Option<Arc<LightLayer>>,
    ) -> Result<Arc<LightLayer>, RenderError> {
        let mut layer = over.and_then(Arc::into_inner).unwrap_or_default();
        let NativeLight { light: shape, map } = &light.light;
        let DrawContext { gpu, scene, .. } = self.context;
        let scene = caster_scene(scene, light.linked.as_deref());
        let drawn = DrawnLight { light: shape, map: map.as_deref(), pixels };
        draw_layer(gpu.workers(), self.surfaces, &scene, drawn, &mut layer)?;
        gpu.stages.record_stage(FrameStage::Light);
        Ok(Arc::new(layer))
    }

    fn draw_sum(&mut self, terms: &NativeTerms, over: Option<Arc<LayerSum>>) -> Result<Arc<LayerSum>, RenderError> {
        let mut sum = over.and_then(Arc::into_inner).unwrap_or_default();
        terms.with(|terms| relight::sum(self.context.gpu.workers(), self.surfaces, terms, &mut sum));
        self.context.gpu.stages.record_stage(FrameStage::Sum);
        Ok(Arc::new(sum))
    }

    fn terms_of_layers(&self, layers: &[GpuTerm<Arc<LightLayer>>]) -> NativeTerms {
        NativeTerms::Layers(layers.to_vec())
    }

    fn terms_of_sums(&self, sums: &[Arc<LayerSum>]) -> NativeTerms {
        NativeTerms::Sums(sums.to_vec())
    }

    fn finish(&mut self) -> Result<(), RenderError> {
        // The CPU has drawn everything when a call returns.
        Ok(())
    }
}

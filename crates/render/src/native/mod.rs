//! Backend on the CPU, through the crate `relight`.

mod bent;
mod cpu;
mod material;
mod relit_light;
mod scene;
mod straight;
mod targets;
mod terms;

use std::sync::Arc;

use relight::{
    AlphaTest, BentMapBuilder, DepthMap, DrawnLight, LayerSum, LayerTerms, LightAov, LightLayer, StraightMapBuilder,
    SurfaceAov,
};
use shadow::{CasterMesh, MapShape, MapSize, PlacedBent, PlacedLight};

pub use cpu::Cpu;

use crate::frame::camera::SampleView;
use crate::frame::shared_scene::{SceneView, SharedScene};
use crate::frame::stages::FrameStage;
use crate::frame::tile::{area, pixel_count};
use crate::frame::{AlphaTestList, FrameBackend, MapSource, ReadyLight, SceneBackend, SceneParts, Term};
use crate::{Aov, Host, RenderError, exposure};
use bent::BentTarget;
use relit_light::{NativeLight, relit_light};
use scene::{HostAlphaTests, HostCasters, HostScene, caster_scene};
use targets::{NativeTargets, SurfacesBuilder};
use terms::NativeTerms;

/// Longest side of pictures and of shadow maps, in pixels.
const MAX_SIDE: u32 = 16_384;

/// Draws the frames of one renderer on the CPU.
#[derive(Debug)]
pub(crate) struct Native {
    cpu: Arc<Cpu>,
    view: SampleView,
    surfaces: SurfacesBuilder,
    bent_maps: BentMapBuilder,
    straight_maps: StraightMapBuilder,
}

impl Native {
    pub fn new(cpu: Arc<Cpu>) -> Self {
        Self {
            cpu,
            view: SampleView::default(),
            surfaces: SurfacesBuilder::default(),
            bent_maps: BentMapBuilder::default(),
            straight_maps: StraightMapBuilder::default(),
        }
    }
}

impl SceneBackend for Native {
    type Device = Cpu;
    type Scene = HostScene;
    type Casters = Arc<HostCasters>;
    type AlphaTests = HostAlphaTests;
    type Links = Vec<[u32; 2]>;

    fn device(&self) -> &Arc<Cpu> {
        &self.cpu
    }

    fn host_of(device: &Cpu) -> &Host {
        &device.host
    }

    fn catch_errors<T>(_: &Cpu, work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError> {
        work()
    }

    /// Does nothing: memory is free once it is dropped.
    fn free_dropped_memory(&self) {}

    fn upload_casters(_: &Cpu, mesh: CasterMesh) -> Result<Arc<HostCasters>, RenderError> {
        let CasterMesh { positions, indices, .. } = mesh;
        Ok(Arc::new(HostCasters { positions, indices }))
    }

    fn caster_bytes(casters: &Arc<HostCasters>) -> u64 {
        (size_of_val(&casters.positions[..]) + size_of_val(&casters.indices[..])) as u64
    }

    fn upload_alpha_tests(_: &Cpu, list: AlphaTestList) -> Result<HostAlphaTests, RenderError> {
        let AlphaTestList { tests, texels } = list;
        Ok(HostAlphaTests { tests, texels: texels.into() })
    }

    fn replace_alpha_tests(
        _: &Cpu,
        known: &HostAlphaTests,
        tests: Vec<AlphaTest>,
    ) -> Result<HostAlphaTests, RenderError> {
        Ok(HostAlphaTests { tests, texels: Arc::clone(&known.texels) })
    }

    fn alpha_test_bytes(tests: &HostAlphaTests) -> u64 {
        (size_of_val(&tests.tests[..]) + tests.texels.len()) as u64
    }

    fn upload_scene(&self, parts: SceneParts) -> Result<(HostScene, u64), RenderError> {
        HostScene::new(&self.cpu, parts)
    }

    fn upload_links(&self, bits: Vec<[u32; 2]>) -> (Vec<[u32; 2]>, u64) {
        let bytes = size_of_val(&bits[..]) as u64;
        (bits, bytes)
    }
}

impl FrameBackend for Native {
    type Map = Arc<DepthMap>;
    type Light = NativeLight;
    type Targets = NativeTargets;
    type Layer = Arc<LightLayer>;
    type Sum = Arc<LayerSum>;
    type Terms = NativeTerms;

    const LAYER_BYTES_PER_PIXEL: u64 = 24;
    const SUM_BYTES_PER_PIXEL: u64 = 12;

    fn sibling(&self) -> Result<Self, RenderError> {
        Ok(Self::new(Arc::clone(&self.cpu)))
    }

    fn max_side(&self) -> u32 {
        MAX_SIDE
    }

    /// Does nothing: draws take the scene of a frame.
    fn bind_scene(&mut self, _: &SharedScene<Self>) {}

    fn new_map(&self, size: MapSize) -> Arc<DepthMap> {
        Arc::new(DepthMap::new(size.side as usize, size.layers as usize))
    }

    fn draw_map(
        &mut self,
        map: &mut Arc<DepthMap>,
        placed: &PlacedLight,
        source: &MapSource<Self>,
    ) -> Result<(), RenderError> {
        if Arc::get_mut(map).is_none() {
            // A layer that is being drawn still reads the map before.
            *map = Arc::new(DepthMap::new(map.side(), map.faces()));
        }
        let into = Arc::get_mut(map).expect("nothing else has it");
        let Self { cpu, bent_maps, straight_maps, .. } = self;
        match placed {
            PlacedLight::Straight(placed) => straight::draw_map(cpu, straight_maps, placed, source, into),
            PlacedLight::Bent(placed) => match &placed.shape {
                Some(shape) => bent::draw_map(cpu, bent_maps, placed, shape, source, BentTarget::Map(into)),
                None => Ok(()),
            },
        }
    }

    fn light(&self, map: &Arc<DepthMap>, placed: PlacedLight) -> NativeLight {
        let is_shadowed = placed.light_profile().shadow_enable;
        NativeLight { light: relit_light(placed), map: is_shadowed.then(|| Arc::clone(map)) }
    }

    fn draw_wireframe(
        &mut self,
        targets: &mut NativeTargets,
        placed: &PlacedBent,
        shape: &MapShape,
        source: &MapSource<Self>,
    ) -> Result<(), RenderError> {
        let (size, picture) = (targets.size, &mut targets.radiance);
        picture.resize(pixel_count(size) as usize, [0.0; 4]);
        let onto = BentTarget::Wireframe { size, picture };
        bent::draw_map(&self.cpu, &mut self.bent_maps, placed, shape, source, onto)
    }

    fn new_targets(size: [u32; 2]) -> NativeTargets {
        NativeTargets::new(size)
    }

    fn target_bytes(targets: &NativeTargets) -> u64 {
        targets.bytes()
    }

    fn max_target_bytes(size: [u32; 2]) -> u64 {
        NativeTargets::max_bytes(size)
    }

    fn set_sample(&mut self, view: &SampleView) {
        self.view = *view;
    }

    fn draw_surfaces(&mut self, targets: &mut NativeTargets, scene: &SceneView<Self>) -> Result<(), RenderError> {
        self.surfaces.draw(&self.cpu, scene, &self.view, &mut targets.surfaces)
    }

    fn begin_sample(
        &mut self,
        targets: &mut NativeTargets,
        _: &SceneView<Self>,
        aov: Aov,
        is_first: bool,
    ) -> Result<(), RenderError> {
        if is_first {
            targets.clear_radiance();
        }
        let NativeTargets { surfaces, sample_sum, radiance, .. } = targets;
        match quantity(aov) {
            None => {
                relight::sum(self.cpu.workers(), surfaces, LayerTerms::Layers(&[]), sample_sum);
            }
            Some(Quantity::OfSurface(aov)) => {
                relight::add_surface_aov(surfaces, aov, self.view.weight, radiance);
                self.cpu.host.stages.record_stage(FrameStage::Fill);
            }
            Some(Quantity::OfLight(_)) => {}
        }
        Ok(())
    }

    fn add_light(
        &mut self,
        targets: &mut NativeTargets,
        scene: &SceneView<Self>,
        aov: Aov,
        light: &ReadyLight<Self>,
    ) -> Result<(), RenderError> {
        let Self { cpu, view, .. } = self;
        let NativeLight { light: shape, map } = &light.light;
        let pixels = scene.tile.clip(light.pixels);
        let drawn = DrawnLight { light: shape, map: map.as_deref(), pixels };
        let casters = caster_scene(scene.scene, light.linked.as_deref());
        let NativeTargets { surfaces, sample_sum, radiance, .. } = targets;
        match quantity(aov) {
            Some(Quantity::OfLight(aov)) => {
                relight::add_light_aov(cpu.workers(), surfaces, &casters, drawn, aov, view.weight, radiance)?;
            }
            _ => {
                relight::add_light(cpu.workers(), surfaces, &casters, drawn, light.factors, sample_sum)?;
            }
        }
        cpu.host.stages.record_stage(FrameStage::Light);
        cpu.host.stages.count(|counters| counters.scissor_pixels += area(pixels));
        Ok(())
    }

    fn end_sample(&mut self, targets: &mut NativeTargets, aov: Aov) -> Result<(), RenderError> {
        if aov == Aov::Beauty {
            let SampleView { fill_factor, weight, .. } = self.view;
            let NativeTargets { surfaces, sample_sum, radiance, .. } = targets;
            relight::add_sample(
                self.cpu.workers(),
                surfaces,
                LayerTerms::Sums(&[&*sample_sum]),
                fill_factor,
                weight,
                radiance,
            );
            self.cpu.host.stages.record_stage(FrameStage::Sum);
        }
        Ok(())
    }

    fn read_radiance(&mut self, targets: &NativeTargets, _: [u32; 2]) -> Result<Vec<[f32; 4]>, RenderError> {
        Ok(targets.radiance.clone())
    }

    fn show_radiance(&mut self, targets: &NativeTargets, _: [u32; 2], exposure: f64) -> Result<Vec<u8>, RenderError> {
        let bytes = relight::display_radiance(self.cpu.workers(), &targets.radiance, exposure::from_stops(exposure));
        self.cpu.host.stages.record_stage(FrameStage::Display);
        Ok(bytes)
    }

    fn draw_fill(&mut self, _: &mut NativeTargets, _: &SceneView<Self>) -> Result<bool, RenderError> {
        Ok(false)
    }

    fn draw_layer(
        &mut self,
        targets: &NativeTargets,
        scene: &SceneView<Self>,
        light: &ReadyLight<Self>,
        pixels: [u32; 4],
        over: Option<Arc<LightLayer>>,
    ) -> Result<Arc<LightLayer>, RenderError> {
        let mut layer = over.and_then(Arc::into_inner).unwrap_or_default();
        let NativeLight { light: shape, map } = &light.light;
        let casters = caster_scene(scene.scene, light.linked.as_deref());
        let drawn = DrawnLight { light: shape, map: map.as_deref(), pixels };
        relight::draw_layer(self.cpu.workers(), &targets.surfaces, &casters, drawn, &mut layer)?;
        self.cpu.host.stages.record_stage(FrameStage::Light);
        Ok(Arc::new(layer))
    }

    fn draw_sum(
        &mut self,
        targets: &NativeTargets,
        terms: &NativeTerms,
        over: Option<Arc<LayerSum>>,
    ) -> Result<Arc<LayerSum>, RenderError> {
        let mut sum = over.and_then(Arc::into_inner).unwrap_or_default();
        terms.with(|terms| relight::sum(self.cpu.workers(), &targets.surfaces, terms, &mut sum));
        self.cpu.host.stages.record_stage(FrameStage::Sum);
        Ok(Arc::new(sum))
    }

    fn terms_of_layers(&self, layers: &[Term<Arc<LightLayer>>]) -> NativeTerms {
        NativeTerms::Layers(layers.to_vec())
    }

    fn terms_of_sums(&self, sums: &[Arc<LayerSum>]) -> NativeTerms {
        NativeTerms::Sums(sums.to_vec())
    }

    fn show(
        &mut self,
        targets: &NativeTargets,
        terms: Option<&NativeTerms>,
        exposure: f64,
    ) -> Result<Vec<u8>, RenderError> {
        let (workers, surfaces, exposure) = (self.cpu.workers(), &targets.surfaces, exposure::from_stops(exposure));
        let no_terms = NativeTerms::Layers(Vec::new());
        let fill_factor = self.view.fill_factor;
        let terms = terms.unwrap_or(&no_terms);
        let bytes = terms.with(|terms| relight::display(workers, surfaces, terms, fill_factor, exposure));
        self.cpu.host.stages.record_stage(FrameStage::Display);
        Ok(bytes)
    }

    /// Does nothing: the CPU has drawn everything when a call returns.
    fn finish(&mut self) -> Result<(), RenderError> {
        Ok(())
    }

    /// Does nothing: no work is left to be drawn.
    fn discard(&mut self) {}

    /// Does nothing: memory of maps grows while they are drawn, so they always fit.
    fn defer_fit_checks(&mut self) {}

    fn have_maps_fitted(&mut self) -> Result<bool, RenderError> {
        Ok(true)
    }
}

/// Quantity that a picture shows in place of radiance.
#[derive(Clone, Copy)]
enum Quantity {
    OfSurface(SurfaceAov),
    OfLight(LightAov),
}

/// Returns the quantity of `aov`; `None` for the beauty and the wireframe. Positions come from depths.
fn quantity(aov: Aov) -> Option<Quantity> {
    Some(match aov {
        Aov::Beauty | Aov::Wireframe => return None,
        Aov::Depth | Aov::Position => Quantity::OfSurface(SurfaceAov::Depth),
        Aov::Normal => Quantity::OfSurface(SurfaceAov::Normal),
        Aov::T => Quantity::OfLight(LightAov::T),
        Aov::Vw => Quantity::OfLight(LightAov::Vw),
        Aov::Direction => Quantity::OfLight(LightAov::Direction),
        Aov::Visibility => Quantity::OfLight(LightAov::Visibility),
    })
}

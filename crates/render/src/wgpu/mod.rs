//! Backend on the GPU, through wgpu.

mod alpha_test;
mod baked_filter;
pub(crate) mod bendy_light;
mod compile_pipelines;
mod composite;
pub(crate) mod display;
mod driver;
mod gbuffer;
mod gpu;
pub(crate) mod gpu_structs;
mod light;
mod lighting;
mod material;
mod passes;
pub(crate) mod pipeline;
pub(crate) mod readback;
mod scene;
pub(crate) mod shaders;
mod straight;
mod straight_map;
mod targets;

use std::mem;
use std::sync::Arc;

use relight::AlphaTest;
use shadow::{CasterMesh, MapShape, MapSize, PlacedBent, PlacedLight};
use wgpu::{BindGroup, BindingResource, Buffer, BufferUsages, CommandEncoder, TextureFormat, TextureView};

pub(crate) use compile_pipelines::compile_pipelines;
pub use gpu::Gpu;

use crate::frame::camera::SampleView;
use crate::frame::shared_scene::{SceneView, SharedScene};
use crate::frame::stages::FrameStage;
use crate::frame::tile::{area, row_bands};
use crate::frame::{AlphaTestList, FrameBackend, MapSource, ReadyLight, SceneBackend, SceneParts, Term};
use crate::{Aov, Host, RenderError};
use alpha_test::GpuAlphaTests;
use bendy_light::BentMapBuffers;
use composite::GpuTerms;
use gbuffer::GbufferView;
use light::WgpuLight;
use passes::Passes;
use pipeline::color_attachment;
use scene::{GpuScene, part_count, view_group};
use straight_map::ShadowMap;
use targets::WgpuTargets;

/// Texels per row of the texture that stores the triangles of a light's links as bits.
const LINK_TEXELS_PER_ROW: usize = 1024;

/// Draws the frames of one renderer on a GPU.
#[derive(Debug)]
pub(crate) struct Wgpu {
    gpu: Arc<Gpu>,
    passes: Arc<Passes>,
    view_uniform: Buffer,
    /// Group 0 of the passes with a camera, for the bound scene; see `view.wgsl`.
    view: Option<BindGroup>,
    pub(crate) bent_buffers: BentMapBuffers,
    /// Work that is recorded and not yet submitted.
    encoder: CommandEncoder,
}

/// Shadow casters on the GPU.
#[derive(Clone, Debug)]
pub(crate) struct GpuCasters {
    /// `array<f32>`, three per vertex.
    pub positions: Buffer,
    /// Three per triangle; triangles without an alpha test come first.
    pub indices: Buffer,
}

impl Wgpu {
    /// Compiles the pipelines that every picture needs.
    pub fn new(gpu: Arc<Gpu>) -> Result<Self, RenderError> {
        let passes = gpu.with_error_scopes(|| Ok(Passes::new(&gpu)))?;
        Self::with(gpu, Arc::new(passes))
    }

    fn with(gpu: Arc<Gpu>, passes: Arc<Passes>) -> Result<Self, RenderError> {
        let view_uniform = gpu.with_error_scopes(|| Ok(gpu.uniform_buffer::<gpu_structs::View>("view")))?;
        let encoder = gpu.encoder();
        Ok(Self { gpu, passes, view_uniform, view: None, bent_buffers: BentMapBuffers::new(), encoder })
    }

    /// Submits the recorded work.
    fn submit(&mut self) {
        let recorded = mem::replace(&mut self.encoder, self.gpu.encoder());
        self.gpu.queue.submit([recorded.finish()]);
    }

    /// Adds what `aov` shows without lights to the radiance, or to zero if `clears`.
    fn draw_base(
        &mut self,
        targets: &WgpuTargets,
        scene: &SceneView<Self>,
        aov: Aov,
        clears: bool,
    ) -> Result<(), RenderError> {
        let Self { gpu, passes, encoder, view, .. } = self;
        let mut pass = targets.begin_lighting(gpu, passes, encoder, view.as_ref(), clears);
        let everywhere = [0, 0, scene.tile.width, scene.tile.height];
        match aov {
            Aov::Beauty => passes.fill.draw(gpu, &mut pass, aov, &[&scene.scene.uploaded.fill], everywhere),
            Aov::Depth | Aov::Normal => passes.inspect.draw(gpu, &mut pass, aov, &[], everywhere),
            _ => {}
        }
        drop(pass);
        gpu.end_stage(encoder, FrameStage::Fill)
    }

    /// Tone-maps the radiance plus the sum of `terms` for a screen, with `exposure` in stops, and reads the upper left
    /// corner back.
    fn draw_display(
        &mut self,
        targets: &WgpuTargets,
        size: [u32; 2],
        terms: Option<&GpuTerms>,
        exposure: f64,
    ) -> Result<Vec<u8>, RenderError> {
        let (gpu, passes) = (Arc::clone(&self.gpu), Arc::clone(&self.passes));
        let lit = targets.lit(&gpu, &passes);
        passes.display.draw(&gpu, &mut self.encoder, &lit.exposed, terms, exposure, &lit.display_view);
        gpu.end_stage(&mut self.encoder, FrameStage::Display)?;
        self.submit();
        let bytes = readback::read::<[u8; 4]>(&gpu, &lit.display, size)?.into_flattened();
        gpu.host.stages.record_stage(FrameStage::Readback);
        gpu.host.stages.count(|counters| counters.bytes += bytes.len() as u64);
        Ok(bytes)
    }

    fn layer_texture(&self, [width, height]: [u32; 2], format: TextureFormat) -> TextureView {
        pipeline::whole_view(&self.gpu.target("layer", width, height, format))
    }
}

impl SceneBackend for Wgpu {
    type Device = Gpu;
    type Scene = GpuScene;
    type Casters = GpuCasters;
    type AlphaTests = GpuAlphaTests;
    type Links = BindGroup;

    fn device(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    fn host_of(device: &Gpu) -> &Host {
        &device.host
    }

    fn catch_errors<T>(device: &Gpu, work: impl FnOnce() -> Result<T, RenderError>) -> Result<T, RenderError> {
        device.with_error_scopes(work)
    }

    fn free_dropped_memory(&self) {
        self.gpu.free_dropped_memory();
    }

    fn upload_casters(gpu: &Gpu, mesh: CasterMesh) -> Result<GpuCasters, RenderError> {
        let (for_vertices, for_triangles) =
            (BufferUsages::STORAGE | BufferUsages::VERTEX, BufferUsages::STORAGE | BufferUsages::INDEX);
        Ok(GpuCasters {
            positions: gpu.upload("the shadow mesh's vertices in bytes", &mesh.positions, for_vertices)?,
            indices: gpu.upload("the shadow mesh's indices in bytes", &mesh.indices, for_triangles)?,
        })
    }

    fn caster_bytes(casters: &GpuCasters) -> u64 {
        casters.positions.size() + casters.indices.size()
    }

    fn upload_alpha_tests(gpu: &Gpu, list: AlphaTestList) -> Result<GpuAlphaTests, RenderError> {
        GpuAlphaTests::new(gpu, list)
    }

    fn replace_alpha_tests(
        gpu: &Gpu,
        known: &GpuAlphaTests,
        tests: Vec<AlphaTest>,
    ) -> Result<GpuAlphaTests, RenderError> {
        known.with_tests(gpu, &tests)
    }

    fn alpha_test_bytes(tests: &GpuAlphaTests) -> u64 {
        tests.bytes()
    }

    fn upload_scene(&self, parts: SceneParts) -> Result<(GpuScene, u64), RenderError> {
        GpuScene::new(&self.gpu, &self.passes.group_layouts, &parts)
    }

    fn upload_links(&self, mut bits: Vec<[u32; 2]>) -> (BindGroup, u64) {
        let (width, height) = (bits.len().min(LINK_TEXELS_PER_ROW), bits.len().div_ceil(LINK_TEXELS_PER_ROW));
        bits.resize(width * height, [0; 2]);
        let (size, format) = ([width as u32, height as u32], TextureFormat::Rg32Uint);
        let view = self.gpu.texture_with("links", size, (format, 1), bytemuck::cast_slice(&bits));
        let layout = &self.passes.group_layouts.links;
        let group = self.gpu.bind_group("links", layout, &[BindingResource::TextureView(&view)]);
        (group, size_of_val(&bits[..]) as u64)
    }
}

impl FrameBackend for Wgpu {
    type Map = ShadowMap;
    type Light = WgpuLight;
    type Targets = WgpuTargets;
    type Layer = TextureView;
    type Sum = TextureView;
    type Terms = GpuTerms;

    const LAYER_BYTES_PER_PIXEL: u64 = 16;
    const SUM_BYTES_PER_PIXEL: u64 = 8;

    fn sibling(&self) -> Result<Self, RenderError> {
        Self::with(Arc::clone(&self.gpu), Arc::clone(&self.passes))
    }

    fn max_side(&self) -> u32 {
        self.gpu.device.limits().max_texture_dimension_2d
    }

    fn bind_scene(&mut self, scene: &SharedScene<Self>) {
        self.view = Some(view_group(&self.gpu, &self.passes.group_layouts, &self.view_uniform, scene));
    }

    fn new_map(&self, size: MapSize) -> ShadowMap {
        self.passes.straight.shadow.new_map(&self.gpu, size)
    }

    fn draw_map(
        &mut self,
        map: &mut ShadowMap,
        placed: &PlacedLight,
        source: &MapSource<Self>,
    ) -> Result<(), RenderError> {
        let Self { gpu, passes, bent_buffers, encoder, .. } = self;
        light::draw_map(gpu, passes, encoder, bent_buffers, map, placed, source)
    }

    fn light(&self, map: &ShadowMap, placed: PlacedLight) -> WgpuLight {
        WgpuLight::new(&self.gpu, &self.passes, map, &placed)
    }

    fn draw_wireframe(
        &mut self,
        targets: &mut WgpuTargets,
        placed: &PlacedBent,
        shape: &MapShape,
        source: &MapSource<Self>,
    ) -> Result<(), RenderError> {
        let Self { gpu, passes, bent_buffers, .. } = self;
        let picture = &targets.lit(gpu, passes).radiance_view;
        passes.bendy.draw_wireframe(gpu, bent_buffers, placed, shape, source, picture)
    }

    fn new_targets(size: [u32; 2]) -> WgpuTargets {
        WgpuTargets::new(size)
    }

    fn target_bytes(targets: &WgpuTargets) -> u64 {
        targets.bytes()
    }

    fn max_target_bytes(size: [u32; 2]) -> u64 {
        WgpuTargets::max_bytes(size)
    }

    fn set_sample(&mut self, view: &SampleView) {
        let uniform = gpu_structs::View::from(view);
        self.gpu.queue.write_buffer(&self.view_uniform, 0, bytemuck::bytes_of(&uniform));
    }

    fn draw_surfaces(
        &mut self,
        targets: &mut WgpuTargets,
        &SceneView { scene, raster, tile }: &SceneView<Self>,
    ) -> Result<(), RenderError> {
        let Self { gpu, passes, view, encoder, .. } = self;
        let group = view.as_ref().expect("a frame binds its scene before it draws");
        let shown = GbufferView { group, scene, size: [raster.width, raster.height], tile };
        passes.gbuffer.draw(gpu, encoder, targets.gbuffer(gpu, passes), shown)?;
        gpu.end_stage(encoder, FrameStage::Gbuffer)
    }

    fn begin_sample(
        &mut self,
        targets: &mut WgpuTargets,
        scene: &SceneView<Self>,
        aov: Aov,
        is_first: bool,
    ) -> Result<(), RenderError> {
        self.draw_base(targets, scene, aov, is_first)
    }

    fn add_light(
        &mut self,
        targets: &mut WgpuTargets,
        scene: &SceneView<Self>,
        aov: Aov,
        light: &ReadyLight<Self>,
    ) -> Result<(), RenderError> {
        let Self { gpu, passes, encoder, view, .. } = self;
        let (pixels, lighting) = (scene.tile.clip(light.pixels), light.lighting(gpu, passes));
        for (part, is_last) in row_bands(pixels, part_count(gpu, scene.scene, area(pixels))) {
            let mut pass = targets.begin_lighting(gpu, passes, encoder, view.as_ref(), false);
            lighting.draw(gpu, &mut pass, aov, &light.groups(), part);
            drop(pass);
            if !is_last {
                gpu.submit_and_wait(encoder)?;
                gpu.host.yield_point()?;
            }
        }
        gpu.end_stage(encoder, FrameStage::Light)?;
        gpu.host.stages.count(|counters| counters.scissor_pixels += area(pixels));
        Ok(())
    }

    fn end_sample(&mut self, _: &mut WgpuTargets, _: Aov) -> Result<(), RenderError> {
        self.submit();
        Ok(())
    }

    fn read_radiance(&mut self, targets: &WgpuTargets, size: [u32; 2]) -> Result<Vec<[f32; 4]>, RenderError> {
        readback::read(&self.gpu, &targets.lit(&self.gpu, &self.passes).radiance, size)
    }

    fn show_radiance(&mut self, targets: &WgpuTargets, size: [u32; 2], exposure: f64) -> Result<Vec<u8>, RenderError> {
        self.draw_display(targets, size, None, exposure)
    }

    fn draw_fill(&mut self, targets: &mut WgpuTargets, scene: &SceneView<Self>) -> Result<bool, RenderError> {
        self.draw_base(targets, scene, Aov::Beauty, true)?;
        Ok(true)
    }

    fn draw_layer(
        &mut self,
        targets: &WgpuTargets,
        scene: &SceneView<Self>,
        light: &ReadyLight<Self>,
        pixels: [u32; 4],
        over: Option<TextureView>,
    ) -> Result<TextureView, RenderError> {
        let layer = over.unwrap_or_else(|| self.layer_texture(targets.size, lighting::LAYER_FORMAT));
        let Self { gpu, passes, encoder, view, .. } = self;
        for (part, is_last) in row_bands(pixels, part_count(gpu, scene.scene, area(pixels))) {
            let clears = part[1] == pixels[1];
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("layer"),
                color_attachments: &[Some(color_attachment(&layer, clears))],
                ..Default::default()
            });
            pass.set_bind_group(0, view.as_ref(), &[]);
            pass.set_bind_group(1, &targets.gbuffer(gpu, passes).surface, &[]);
            light.lighting(gpu, passes).draw_layer(gpu, &mut pass, &light.groups(), part);
            drop(pass);
            if !is_last {
                gpu.submit_and_wait(encoder)?;
                gpu.host.yield_point()?;
            }
        }
        gpu.end_stage(encoder, FrameStage::Light)?;
        Ok(layer)
    }

    fn draw_sum(
        &mut self,
        targets: &WgpuTargets,
        terms: &GpuTerms,
        over: Option<TextureView>,
    ) -> Result<TextureView, RenderError> {
        let sum = over.unwrap_or_else(|| self.layer_texture(targets.size, composite::SUM_FORMAT));
        self.passes.composite.draw_sum(&mut self.encoder, terms, &sum);
        self.gpu.end_stage(&mut self.encoder, FrameStage::Sum)?;
        Ok(sum)
    }

    fn terms_of_layers(&self, layers: &[Term<TextureView>]) -> GpuTerms {
        self.passes.composite.layers(&self.gpu, layers)
    }

    fn terms_of_sums(&self, sums: &[TextureView]) -> GpuTerms {
        self.passes.composite.sums(&self.gpu, sums)
    }

    fn show(&mut self, targets: &WgpuTargets, terms: Option<&GpuTerms>, exposure: f64) -> Result<Vec<u8>, RenderError> {
        self.draw_display(targets, targets.size, terms, exposure)
    }

    fn finish(&mut self) -> Result<(), RenderError> {
        self.gpu.submit_and_wait(&mut self.encoder)
    }

    fn discard(&mut self) {
        self.encoder = self.gpu.encoder();
        self.bent_buffers.clear_deferred();
    }

    fn defer_fit_checks(&mut self) {
        self.bent_buffers.defer_fit_checks();
    }

    fn have_maps_fitted(&mut self) -> Result<bool, RenderError> {
        self.bent_buffers.check_deferred_fits(&self.gpu)
    }
}

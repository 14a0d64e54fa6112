//! Surfaces and light of a view or a tile on the CPU.

use relight::{
    CameraRays, FillColors, LayerSum, PicturePart, SurfaceScene, Surfaces, VisibilityBuffer, VisibilityBuilder,
    VisibleTriangles,
};
use scene::Projection;

use super::Native;
use super::scene::{HostScene, caster_scene};
use crate::RenderError;
use crate::frame::camera::SampleView;
use crate::frame::shared_scene::SceneView;
use crate::frame::stages::FrameStage;
use crate::frame::tile::pixel_count;
use crate::native::Cpu;

/// Surfaces that pixels show, in CPU memory, with the light that was added up on them.
#[derive(Debug)]
pub(crate) struct NativeTargets {
    pub size: [u32; 2],
    pub surfaces: Surfaces,
    /// Sum of the lights added so far in the current sample.
    pub sample_sum: LayerSum,
    /// Sum of the samples before the current one: linear RGBA, rows from the top.
    pub radiance: Vec<[f32; 4]>,
}

impl NativeTargets {
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, surfaces: Surfaces::default(), sample_sum: LayerSum::default(), radiance: Vec::new() }
    }

    /// Returns the largest number of bytes of targets of `size` pixels.
    pub fn max_bytes(size: [u32; 2]) -> u64 {
        let (blocks, radiance) = (Surfaces::max_blocks(size), pixel_count(size) * size_of::<[f32; 4]>() as u64);
        Surfaces::bytes_of(blocks) + LayerSum::bytes(blocks) + radiance
    }

    pub fn bytes(&self) -> u64 {
        self.surfaces.bytes() + LayerSum::bytes(self.sample_sum.block_count()) + size_of_val(&self.radiance[..]) as u64
    }

    /// Makes the radiance zero. It has the size of the surfaces.
    pub fn clear_radiance(&mut self) {
        let [width, height] = self.surfaces.size().map(|side| side as usize);
        self.radiance.clear();
        self.radiance.resize(width * height, [0.0; 4]);
    }
}

/// Memory for drawing the surfaces of pictures, reused from one to the next.
#[derive(Debug, Default)]
pub(crate) struct SurfacesBuilder {
    visible: VisibilityBuffer,
    builder: VisibilityBuilder,
}

impl SurfacesBuilder {
    /// Draws the surfaces of a tile, as the camera of `view` sees it.
    pub fn draw(
        &mut self,
        cpu: &Cpu,
        &SceneView { scene, raster, tile }: &SceneView<Native>,
        view: &SampleView,
        into: &mut Surfaces,
    ) -> Result<(), RenderError> {
        let HostScene { materials, .. } = &scene.uploaded;
        let triangles = caster_scene(scene, None);
        let near = match raster.projection {
            Projection::Perspective { znear, .. } => Some(znear as f32),
            Projection::Orthographic { .. } => None,
        };
        let part = PicturePart {
            clip_from_scene: view.clip_from_scene,
            near,
            camera: camera(view),
            whole: [raster.width, raster.height].map(|side| side as usize),
            first: [tile.x, tile.y].map(|pixels| pixels as usize),
            size: [tile.width, tile.height].map(|side| side as usize),
        };
        let drawn = VisibleTriangles { scene: &triangles, both_sides: &materials.both_sides };
        self.builder.draw(cpu.workers(), &drawn, &part, &mut self.visible)?;
        cpu.host.stages.record_stage(FrameStage::Gbuffer);
        let fill = &scene.posed.scene.fill;
        let fill = FillColors { sky: fill.sky.as_vec3().to_array(), ground: fill.ground.as_vec3().to_array() };
        let shown = SurfaceScene { triangles: &triangles, materials: &materials.materials };
        into.update(cpu.workers(), &shown, part.camera, fill, &self.visible)?;
        cpu.host.stages.record_stage(FrameStage::Surfaces);
        Ok(())
    }
}

fn camera(view: &SampleView) -> CameraRays {
    CameraRays {
        origin: view.ray_origin,
        origin_dx: view.ray_origin_dx,
        origin_dy: view.ray_origin_dy,
        direction: view.ray_direction,
        direction_dx: view.ray_direction_dx,
        direction_dy: view.ray_direction_dy,
        depth_from_z: view.depth_from_z,
        tile_origin: view.tile_origin,
    }
}

//! Maps of BendyLights on the CPU.

use relight::{AlphaTests, BentFace, BentMap, DepthMap, TubeSpace, Wireframe};
use shadow::{CastersNearSlabs, MapShape, PlacedBent, slab_bounds, slabs_of_map};

use super::Native;
use super::scene::{HostAlphaTests, caster_scene};
use crate::RenderError;
use crate::frame::MapSource;
use crate::frame::stages::FrameStage;
use crate::native::Cpu;

/// Target of a map's triangles.
pub(crate) enum BentTarget<'a> {
    /// Depths, at the map's size.
    Map(&'a mut DepthMap),
    /// A drawing of the triangles, linear RGBA.
    Wireframe { size: [u32; 2], picture: &'a mut [[f32; 4]] },
}

/// Draws the triangles of a light's map. `shape` is that of the map.
pub(crate) fn draw_map(
    cpu: &Cpu,
    work: &mut relight::BentMapBuilder,
    placed: &PlacedBent,
    shape: &MapShape,
    source: &MapSource<Native>,
    onto: BentTarget,
) -> Result<(), RenderError> {
    let MapSource { scene, casting, shadows, .. } = source;
    let (origin, workers, tube) = (scene.posed.origin_in_world, cpu.workers(), &placed.part.tube);
    let slabs = slabs_of_map(tube, shape, shadows);
    let clusters = &casting.casters.clusters;
    let near = CastersNearSlabs::new(clusters, tube, origin, shape, &slabs, shadows.culling);
    let bounds = slab_bounds(&slabs);
    let slabs: Vec<_> = slabs.into_iter().map(|boxed| boxed.slab).collect();
    let faces: Vec<BentFace> = (0..shape.face_count()).map(|face| shape.face(face)).collect();
    let drawn = BentMap {
        space: TubeSpace { from_scene: placed.tube_from_scene, frame: tube.frame, up: tube.up.as_vec3() },
        slabs: &slabs,
        bounds,
        faces: &faces,
        cube_slope: placed.map.slope,
        texels_per_vw: shape.texels_per_vw() as f32,
        tolerance_texels: shadows.split_above_texels(),
    };
    let host = &casting.casters.uploaded;
    let casters = relight::BentCasters {
        positions: &host.positions,
        indices: &host.indices,
        opaque_triangles: clusters.opaque_triangles,
        leaves: &near.leaves,
        blocks: &near.blocks,
        alpha_tests: casting.alpha_tests.map_or_else(AlphaTests::default, HostAlphaTests::all),
        scene: &caster_scene(scene, None),
    };
    work.map_vertices(workers, &drawn, &casters);
    cpu.host.stages.record_stage(FrameStage::Vertices);
    work.map_triangles(workers, &drawn, &casters);
    cpu.host.stages.record_stage(FrameStage::Triangles);
    let split = work.split(workers, &drawn, &casters)?;
    cpu.host.stages.record_stage(FrameStage::Split);
    let triangles = match onto {
        BentTarget::Map(into) => work.draw(workers, &drawn, &casters, into)?,
        BentTarget::Wireframe { size, picture } => {
            let wireframe = Wireframe {
                size: size.map(|side| side as usize),
                t_of_light: [placed.part.t_start, placed.part.t_span],
                t_base: shape.t_base(),
                t_span: shape.t_span(),
            };
            return Ok(work.draw_wireframe(workers, &wireframe, picture)?);
        }
    };
    cpu.host.stages.record_stage(FrameStage::Draw);
    cpu.host.stages.count(|counters| {
        counters.triangles_seen += u64::from(near.triangles);
        counters.triangles_split += split;
        counters.triangles_drawn += triangles;
        counters.texels += shape.face_count() as u64 * u64::from(shape.side).pow(2);
    });
    Ok(())
}

#[cfg(test)]
mod tests;

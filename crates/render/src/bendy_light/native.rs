//! BendyLights on the CPU: the light's numbers for `relight`, and its map.

use glam::{Mat3, Mat4, Vec3};
use light::{CheckedLight, LightPart, Tube};
use relight::{AlphaTests, BentFace, BentMap, BentMapParams, DepthMap, RelitBent, TubeSpace};

use super::map_shape::MapShape;
use super::near_slabs::CastersNearSlabs;
use super::pass::fit_bent_map;
use super::slab;
use super::{mesh_error_in_tube, tube_from_scene};
use crate::gpu_scene::GpuScene;
use crate::host_scene::caster_scene;
use crate::linked::CasterSource;
use crate::stages::FrameStage;
use crate::{Gpu, RenderError, ShadowSettings};

/// Draws the shadow map of `light` into `into`, at its size. The casters are those of the source, or its coarse ones if
/// they are accurate enough. Returns the shape of the map.
pub(crate) fn draw_map(
    gpu: &Gpu,
    work: &mut relight::BentMapBuilder,
    light: &CheckedLight,
    tube: &Tube<f64>,
    source: CasterSource,
    into: &mut DepthMap,
) -> Result<MapShape, RenderError> {
    let CasterSource { scene, shadows, .. } = source;
    let (origin, workers) = (scene.posed.origin_in_world, gpu.workers());
    let part = tube.part_near(origin, scene.posed.half_extent);
    let tube = &part.tube;
    let (casting, map) = fit_bent_map(gpu, tube, light.light(), source)?;
    let slabs = slab::slabs_of_map(tube, &map, shadows);
    let near = CastersNearSlabs::new(casting.casters, tube, origin, &map, &slabs, shadows.culling);
    let bounds = slab::bounds(&slabs);
    let slabs: Vec<_> = slabs.into_iter().map(|boxed| boxed.slab).collect();
    let faces: Vec<BentFace> = (0..map.face_count()).map(|face| face_of(&map, face)).collect();
    let drawn = BentMap {
        space: TubeSpace {
            from_scene: Mat4::from_cols_array_2d(&tube_from_scene(tube, origin)),
            frame: tube.frame,
            up: tube.up.as_vec3(),
        },
        slabs: &slabs,
        bounds,
        faces: &faces,
        cube_slope: map.is_cube().then(|| map.slope() as f32),
        texels_per_vw: map.texels_per_vw() as f32,
        tolerance_texels: shadows.split_above_texels(),
    };
    let host = casting.casters.host.as_deref().expect("it is there where the processor draws");
    let casters = relight::BentCasters {
        positions: &host.positions,
        indices: &host.indices,
        opaque_triangles: casting.casters.opaque_indices / 3,
        leaves: &near.leaves,
        blocks: &near.blocks,
        alpha_tests: casting.alpha_tests.map_or_else(AlphaTests::default, crate::alpha_test::GpuAlphaTests::host),
        scene: &caster_scene(scene, None),
    };
    work.map_vertices(workers, &drawn, &casters);
    gpu.stages.record_stage(FrameStage::Vertices);
    work.map_triangles(workers, &drawn, &casters);
    gpu.stages.record_stage(FrameStage::Triangles);
    let split = work.split(workers, &drawn, &casters)?;
    gpu.stages.record_stage(FrameStage::Split);
    let triangles = work.draw(workers, &drawn, &casters, into)?;
    gpu.stages.record_stage(FrameStage::Draw);
    gpu.stages.count(|counters| {
        counters.triangles_seen += u64::from(near.triangles);
        counters.triangles_split += split;
        counters.triangles_drawn += triangles;
        counters.texels += map.face_count() as u64 * u64::from(map.side).pow(2);
    });
    Ok(map)
}

fn face_of(map: &MapShape, face: usize) -> BentFace {
    let shadow = map.shadow_uniforms(face);
    let [x, y, z] = shadow.clip_from_mapped.map(|[x, y, z, _]| Vec3::new(x, y, z));
    BentFace {
        clip_from_mapped: Mat3::from_cols(x, y, z),
        row_divisor: shadow.row,
        depth_per_t: shadow.depth_per_t,
        has_casters: map.has_casters(face),
    }
}

/// Makes the light in the form that `relight` draws, with the shape of its map.
pub(crate) fn placed(
    tube: &Tube<f64>,
    scene: &GpuScene,
    map: Option<&MapShape>,
    shadows: &ShadowSettings,
) -> RelitBent {
    let origin = scene.posed.origin_in_world;
    let LightPart { tube, .. } = &tube.part_near(origin, scene.posed.half_extent);
    let params = map.map_or_else(BentMapParams::default, |map| BentMapParams {
        t_base: map.t_base() as f32,
        t_span: map.t_span() as f32,
        t_last: map.t_last() as f32,
        slope: map.is_cube().then(|| map.slope() as f32),
        tolerance_texels: shadows.bent_tolerance_texels(),
        mesh_error: mesh_error_in_tube(tube, map),
        fits: map.fits(),
        filter: shadows.filter,
    });
    RelitBent::new(tube, Mat4::from_cols_array_2d(&tube_from_scene(tube, origin)), params)
}

#[cfg(test)]
mod tests;

//! Maps points on the adapter as bent shadow maps do, for `bendylights-studies stress` and for tests.

use glam::{DVec3, Vec4};
use light::Tube;
use shadow::{VERTICES_PER_BLOCK, slabs, t_max};
use wgpu::BufferUsages;

use crate::wgpu::bendy_light::bent_map::bent_map_uniforms;
use crate::wgpu::bendy_light::gpu_structs::{BentMap, Slab};
use crate::wgpu::bendy_light::slab::{SLABS_PER_UNIFORM, padded};
use crate::wgpu::pipeline::entire;
use crate::wgpu::readback;
use crate::wgpu::shaders;
use crate::{Gpu, RenderError};

/// Computes (V, W, R, t) of scene vertices as a light's shadow map has them, with lengths in tube space, in f32 with
/// the map's own shader. `None` for a point that is in no slab, or in slabs of distant parts of the tube.
///
/// Points are transformed to scene space, around the center of their bounds, in f64 and rounded there. The accuracy is
/// that of [`light::Tube`] with eps = 2^-24, at positions of that size.
pub fn map_points(gpu: &Gpu, tube: &Tube<f64>, points_in_world: &[DVec3]) -> Result<Vec<Option<Vec4>>, RenderError> {
    let bound = |pick: fn(DVec3, DVec3) -> DVec3| points_in_world.iter().copied().reduce(pick).unwrap_or_default();
    let (min, max) = (bound(DVec3::min), bound(DVec3::max));
    let origin = min / 2.0 + max / 2.0;
    let positions: Vec<[f32; 3]> = points_in_world.iter().map(|&p| (p - origin).as_vec3().to_array()).collect();
    let last = t_max(tube, origin, max / 2.0 - min / 2.0);
    let slabs = slabs(tube, 0.0, [0.0, last], 1.0);
    gpu.with_error_scopes(|| {
        let mut mapped = vec![None; positions.len()];
        for turn in slabs.chunks(SLABS_PER_UNIFORM) {
            let vertex_count = positions.len() as u32;
            let block_count = vertex_count.div_ceil(VERTICES_PER_BLOCK as u32);
            let map = BentMap { vertex_count, block_count, ..bent_map_uniforms(tube, origin, turn) };
            for (known, found) in mapped.iter_mut().zip(dispatch(gpu, &map, &padded(turn), &positions)?) {
                *known = known.or(found);
            }
        }
        Ok(mapped)
    })
}

/// Maps positions in scene space into `slabs`.
fn dispatch(
    gpu: &Gpu,
    map: &BentMap,
    slabs: &[Slab],
    positions: &[[f32; 3]],
) -> Result<Vec<Option<Vec4>>, RenderError> {
    let pipeline = gpu.compute_pipeline("map_vertices", shaders::BENT_MAP_VERTICES, "map_vertices");
    let results = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let uniform = gpu.uniform_with("bent map", map);
    let slabs = gpu.buffer_with("slabs", slabs, BufferUsages::UNIFORM);
    let mapped = gpu.buffer_with("mapped vertices", &vec![[0.0_f32; 4]; positions.len()], results);
    let vertex_slab = gpu.buffer_with("slab of each vertex", &vec![u32::MAX; positions.len()], results);
    let positions = gpu.buffer_with("positions", positions, BufferUsages::STORAGE);
    let blocks: Vec<u32> = (0..map.block_count).collect();
    let blocks = gpu.buffer_with("blocks of vertices", &blocks, BufferUsages::STORAGE);

    let buffers = entire(&[&uniform, &slabs, &positions, &mapped, &vertex_slab, &blocks]);
    let group = gpu.bind_group("map_vertices", &pipeline.get_bind_group_layout(0), &buffers);
    gpu.dispatch(&pipeline, &[(0, group)], map.block_count);
    let mapped = readback::read_buffer::<[f32; 4]>(gpu, &mapped)?;
    let slab = readback::read_buffer::<u32>(gpu, &vertex_slab)?;
    let one = |(mapped, slab): (&[f32; 4], &u32)| (*slab < map.slab_count).then(|| Vec4::from_array(*mapped));
    Ok(mapped.iter().zip(&slab).map(one).collect())
}

//! Maps points on the adapter as bent shadow maps do, for `bendylights-studies stress` and for tests.

use glam::{DVec3, Vec4};
use light::Tube;
use wgpu::BufferUsages;
use wgpu::util::{BufferInitDescriptor, DeviceExt};

use super::gpu_structs::{BentMap, Slab};
use super::shadow::bent_map_uniforms;
use super::slab::{SLABS_PER_UNIFORM, slabs};
use super::t_max;
use crate::clusters::VERTICES_PER_BLOCK;
use crate::{Gpu, RenderError, readback, shaders};

/// Computes (V, W, R, t) of scene vertices as a light's shadow map has them, with lengths in tube space, in f32 with
/// the map's own shader. `None` for a point that is in no slab, or in slabs of distant parts of the tube.
///
/// Points are transformed to scene space, around the center of their bounds, in f64 and rounded there. The accuracy is
/// that of [`light::Tube`] with eps = 2^-24, at positions of that size.
pub fn map_points(
    gpu: &Gpu,
    tube: &Tube<f64>,
    points_in_world: &[DVec3],
) -> Result<Vec<Option<Vec4>>, RenderError> {
    let bound =
        |pick: fn(DVec3, DVec3) -> DVec3| points_in_world.iter().copied().reduce(pick).unwrap_or_default();
    let (min, max) = (bound(DVec3::min), bound(DVec3::max));
    let origin = min / 2.0 + max / 2.0;
    let positions: Vec<[f32; 3]> =
        points_in_world.iter().map(|&p| (p - origin).as_vec3().to_array()).collect();
    let last = t_max(tube, origin, max / 2.0 - min / 2.0);
    let slabs = slabs(tube, (0.0, [0.0, last]), 1.0, 1.0);
    gpu.with_error_scopes(|| {
        let mut mapped = vec![None; positions.len()];
        for turn in slabs.chunks(SLABS_PER_UNIFORM) {
            let vertex_count = positions.len() as u32;
            let block_count = vertex_count.div_ceil(VERTICES_PER_BLOCK as u32);
            let map = BentMap { vertex_count, block_count, ..bent_map_uniforms(tube, origin, turn) };
            let mut table: Vec<Slab> = turn.iter().map(|slab| (&slab.0).into()).collect();
            table.resize(SLABS_PER_UNIFORM, Slab::default());
            for (known, found) in mapped.iter_mut().zip(dispatch(gpu, &map, &table, &positions)?) {
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
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("map_vertices"),
        layout: None,
        module: &gpu.shader_module("map_vertices", shaders::BENT_MAP_VERTICES),
        entry_point: Some("map_vertices"),
        compilation_options: wgpu::PipelineCompilationOptions::default(),
        cache: None,
    });
    let init = |label, contents: &[u8], usage| {
        gpu.device.create_buffer_init(&BufferInitDescriptor { label: Some(label), contents, usage })
    };
    let results = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let uniform = init("bent map", bytemuck::bytes_of(map), BufferUsages::UNIFORM);
    let slabs = init("slabs", bytemuck::cast_slice(slabs), BufferUsages::UNIFORM);
    let mapped = init("mapped vertices", &vec![0; 16 * positions.len()], results);
    let vertex_slab = init("slab of each vertex", &vec![0xff; 4 * positions.len()], results);
    let positions = init("positions", bytemuck::cast_slice(positions), BufferUsages::STORAGE);
    let blocks: Vec<u32> = (0..map.block_count).collect();
    let blocks = init("blocks of vertices", bytemuck::cast_slice(&blocks), BufferUsages::STORAGE);

    let buffers = [&uniform, &slabs, &positions, &mapped, &vertex_slab, &blocks];
    let buffers = buffers.map(wgpu::Buffer::as_entire_binding);
    let group = gpu.bind_group("map_vertices", &pipeline.get_bind_group_layout(0), &buffers);
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
    {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(map.block_count, 1, 1);
    }
    gpu.queue.submit([encoder.finish()]);
    let mapped = readback::read_buffer::<[f32; 4]>(gpu, &mapped)?;
    let slab = readback::read_buffer::<u32>(gpu, &vertex_slab)?;
    let one = |(mapped, slab): (&[f32; 4], &u32)| (*slab < map.slab_count).then(|| Vec4::from_array(*mapped));
    Ok(mapped.iter().zip(&slab).map(one).collect())
}

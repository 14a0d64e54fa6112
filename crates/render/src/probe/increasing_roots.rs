//! Runs the solver on the adapter and measures its time.

use std::time::{Duration, Instant};

use glam::Vec3;
use light::{Curve, Roots};
use wgpu::BufferUsages;

use crate::wgpu::bendy_light::gpu_curve;
use crate::wgpu::pipeline::entire;
use crate::wgpu::readback;
use crate::wgpu::shaders;
use crate::{Gpu, RenderError};

/// Threads of a workgroup; the shader has the same number.
const WORKGROUP: usize = 64;

/// Solves [`light::increasing_roots`] for each curve and point on the adapter, with the shader code of pictures.
///
/// Solves all cases once, then `dispatches` times more under the clock, which excludes uploads and readback. Returns
/// the duration of one pass over all cases. Takes at most 500 000 cases, which fit into the buffers of every device.
pub fn increasing_roots(
    gpu: &Gpu,
    cases: &[(Curve<f32>, Vec3)],
    dispatches: u32,
) -> Result<(Vec<Roots<f32>>, Duration), RenderError> {
    gpu.with_error_scopes(|| {
        let curves: Vec<_> = cases.iter().map(|(curve, _)| gpu_curve(curve, 0.0, 1.0)).collect();
        let points: Vec<[f32; 4]> = cases.iter().map(|(_, q)| q.extend(0.0).to_array()).collect();
        let curves = gpu.buffer_with("curves", &curves, BufferUsages::STORAGE);
        let points = gpu.buffer_with("points", &points, BufferUsages::STORAGE);
        // Filled so that an unsolved case differs from one without roots.
        let unsolved = vec![[f32::NAN; 4]; cases.len()];
        let results = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
        let found = gpu.buffer_with("found", &unsolved, results);

        let pipeline = gpu.compute_pipeline("increasing_roots", shaders::INCREASING_ROOTS, "main");
        let buffers = entire(&[&curves, &points, &found]);
        let group = gpu.bind_group("increasing_roots", &pipeline.get_bind_group_layout(0), &buffers);
        let solve = |times: u32| {
            let mut encoder = gpu.encoder();
            for _ in 0..times {
                let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
                pass.set_pipeline(&pipeline);
                pass.set_bind_group(0, &group, &[]);
                pass.dispatch_workgroups(cases.len().div_ceil(WORKGROUP) as u32, 1, 1);
            }
            gpu.queue.submit([encoder.finish()]);
            gpu.wait()
        };
        // A driver compiles at the first dispatch.
        solve(1)?;
        let start = Instant::now();
        solve(dispatches)?;
        let each = start.elapsed() / dispatches;
        let found = readback::read_buffer::<[f32; 4]>(gpu, &found)?;
        Ok((found.into_iter().map(roots).collect(), each))
    })
}

/// Keeps a NaN that the shader did not overwrite as a root, so that tests see it.
fn roots([left, right, has_left, has_right]: [f32; 4]) -> Roots<f32> {
    Roots { left, right, has_left: has_left != 0.0, has_right: has_right != 0.0 }
}

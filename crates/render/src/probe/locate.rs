//! Locates points in a light on the adapter, with the shaders of pictures, for `eval` and for tests.

use glam::{DVec3, Vec3};
use light::{EndMode, Tube, TubeLocation, TubePoint};
use relight::BentMapParams;
use shadow::{PlacedBent, tube_from_scene};
use wgpu::BufferUsages;

use crate::wgpu::bendy_light::gpu_structs::LocatedRoot;
use crate::wgpu::bendy_light::{Baked, segments, uniform};
use crate::wgpu::pipeline::entire;
use crate::wgpu::readback;
use crate::wgpu::shaders;
use crate::{Gpu, RenderError, ShadowFilter};

/// Threads of a workgroup; the shader has the same number.
const WORKGROUP: usize = 64;
/// Capacity of a dispatch in roots: 16 MiB, well within the limits of every device.
const ROOTS_PER_DISPATCH: usize = (16 << 20) / size_of::<LocatedRoot>();

/// Locates `points_in_world` in `light` in f32, with the shader code of pictures.
///
/// Points are transformed to tube space in f64 and rounded there, to the space of the light part that contains them, as
/// for a scene (see [`light::LightPart`]). The accuracy is that of [`light::Tube`] with eps = 2^-24.
pub fn locate(gpu: &Gpu, light: &Tube<f64>, points_in_world: &[DVec3]) -> Result<Vec<TubeLocation>, RenderError> {
    let part = light.part_near_points(points_in_world);
    let tube_from_scene = tube_from_scene(&part.tube, DVec3::ZERO);
    let placed = PlacedBent { part, tube_from_scene, shape: None, map: BentMapParams::default() };
    let tube = &placed.part.tube;
    gpu.with_error_scopes(|| {
        let wgsl = Baked::of(tube, false, ShadowFilter::default()).into_wgsl(shaders::LOCATE);
        let pipeline = gpu.compute_pipeline("locate", &wgsl, "locate");
        let mut locations = Vec::with_capacity(points_in_world.len());
        for points in points_in_world.chunks(ROOTS_PER_DISPATCH / roots_a_point(tube)) {
            locations.extend(dispatch(gpu, &pipeline, &placed, points)?);
        }
        Ok(locations)
    })
}

/// Returns the largest number of roots of a point: two per segment, and one on the extension.
fn roots_a_point(tube: &Tube<f64>) -> usize {
    2 * tube.n + usize::from(tube.end_mode() == EndMode::Extend)
}

fn dispatch(
    gpu: &Gpu,
    pipeline: &wgpu::ComputePipeline,
    placed: &PlacedBent,
    points_in_world: &[DVec3],
) -> Result<Vec<TubeLocation>, RenderError> {
    let part = &placed.part;
    let tube = &part.tube;
    let stride = roots_a_point(tube);
    let points: Vec<[f32; 4]> =
        points_in_world.iter().map(|&p| tube.placement.tube_from_world(p).as_vec3().extend(0.0).to_array()).collect();
    let results = BufferUsages::STORAGE | BufferUsages::COPY_SRC;
    let light = gpu.uniform_with("light", &uniform(placed));
    let segments = gpu.buffer_with("segments", &segments(tube), BufferUsages::UNIFORM);
    let points = gpu.buffer_with("points", &points, BufferUsages::STORAGE);
    // Filled so that an unwritten point differs from one without roots.
    let counts = gpu.buffer_with("root counts", &vec![u32::MAX; points_in_world.len()], results);
    let roots = vec![0xff_u8; size_of::<LocatedRoot>() * stride * points_in_world.len()];
    let roots = gpu.buffer_with("located roots", &roots, results);

    let group = |index, buffers: &[&wgpu::Buffer]| {
        (index, gpu.bind_group("locate", &pipeline.get_bind_group_layout(index), &entire(buffers)))
    };
    let groups = [group(0, &[&points, &counts, &roots]), group(2, &[&light, &segments])];
    gpu.dispatch(pipeline, &groups, points_in_world.len().div_ceil(WORKGROUP) as u32);
    let counts = readback::read_buffer::<u32>(gpu, &counts)?;
    let roots = readback::read_buffer::<LocatedRoot>(gpu, &roots)?;
    let found = counts.iter().zip(roots.chunks(stride));
    found
        .map(|(&count, roots)| {
            let roots = roots.get(..count as usize).ok_or_else(unwritten)?;
            Ok(part.to_whole_light(&location(tube, roots)))
        })
        .collect()
}

fn unwritten() -> RenderError {
    RenderError::Gpu("some points were not evaluated".into())
}

/// Converts the roots of one point to tube coordinates in world units. Of several roots, the one with the smallest `|r|
/// / R` becomes the location of the point.
fn location(tube: &Tube<f64>, roots: &[LocatedRoot]) -> TubeLocation {
    let offset2 = |r: &LocatedRoot| r.v_len * r.v_len + r.w_len * r.w_len;
    let rho2 = |a: &LocatedRoot, b: &LocatedRoot| offset2(a) * b.radius * b.radius;
    let best = roots.iter().reduce(|best, root| if rho2(root, best) < rho2(best, root) { root } else { best });
    let t = |root: &LocatedRoot| f64::from(root.segment) + f64::from(root.u);
    let describe = |root: &LocatedRoot| {
        let over_radius = |x: f32| if root.radius > 0.0 { f64::from(x / root.radius) } else { 0.0 };
        TubePoint {
            segment: root.segment as usize,
            u: f64::from(root.u),
            t: t(root),
            v: over_radius(root.v_len),
            w: over_radius(root.w_len),
            radius: f64::from(root.radius) * tube.placement.world_per_tube,
            direction: tube.placement.rotation * Vec3::from(root.direction).as_dvec3(),
        }
    };
    TubeLocation { point: best.map(describe), roots: roots.iter().map(t).collect() }
}

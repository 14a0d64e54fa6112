//! BendyLights on the GPU: the tube as buffers, bent shadow maps, and location of points.

mod alpha_tested_draw;
mod faces;
mod fit;
pub(crate) mod gpu_structs;
mod increasing_roots;
mod locate;
mod map_shape;
mod mapped;
mod native;
mod near_slabs;
mod pass;
mod shadow;
mod shadow_buffers;
mod slab;
#[cfg(test)]
pub(crate) mod tests;
#[cfg(test)]
pub(crate) mod walk;
mod wireframe;

use glam::{DMat3, DMat4, DVec3};
use light::MAX_EXTENT;
use light::{Curve, DirectionMode, EndMode, FrameMode, LightPart, Segment, Tube};

use crate::baked_filter::BakedFilter;
use crate::clusters::ClusterBounds;
use crate::gpu_structs::Mat4;
use crate::shadow_settings::with_filter;
use crate::{ShadowFilter, ShadowSettings};

pub(crate) use faces::face_count;
pub use increasing_roots::increasing_roots;
pub use locate::locate;
pub(crate) use map_shape::MapShape;
pub use mapped::map_points;
pub(crate) use native::{draw_map, placed};
pub(crate) use pass::{BendyPass, BendySlot, corners_in_world};
pub(crate) use shadow_buffers::BentMapBuffers;

/// Length of the array of segments in `tube.wgsl`: the most segments of a light, and the extension.
const SEGMENT_CAPACITY: usize = light::MAX_SEGMENTS + 1;

/// Largest color and intensity. Their product is finite in f32, and `profile.wgsl` keeps its product with exposure,
/// decay and the BRDF within f32.
const MAX_INTENSITY: f32 = 1e15;

/// Returns the matrix from scene space (world axes, origin at `scene_origin`) to tube space, as columns, composed in
/// f64.
fn tube_from_scene(tube: &Tube<f64>, scene_origin: DVec3) -> Mat4 {
    let placement = &tube.placement;
    let rotation = placement.rotation.transpose() * DMat3::from_diagonal(DVec3::splat(1.0 / placement.world_per_tube));
    let offset = placement.tube_from_world(scene_origin);
    let matrix = DMat4::from_cols(
        rotation.x_axis.extend(0.0),
        rotation.y_axis.extend(0.0),
        rotation.z_axis.extend(0.0),
        offset.extend(1.0),
    );
    matrix.as_mat4().to_cols_array_2d()
}

/// Returns the upper bound of t within `half_extent` of the scene's origin: the end of the light, or of the part of its
/// extension that reaches the scene.
pub(crate) fn t_max(tube: &Tube<f64>, scene_origin: DVec3, half_extent: DVec3) -> f64 {
    let n = tube.n as f64;
    if tube.end_mode() == EndMode::Cut {
        return n;
    }
    let last = &tube.segments[tube.n].curve;
    let scene = ClusterBounds { center: scene_origin, half: half_extent };
    let farthest = scene
        .corners()
        .into_iter()
        .map(|corner| (tube.placement.tube_from_world(corner) - last.b0).dot(last.d0))
        .fold(0.0, f64::max);
    // One percent more, so that the far corner itself is inside.
    n + (farthest / (2.0 * last.d0.length_squared())) * 1.01 + 1e-3
}

fn gpu_curve(curve: &Curve<f32>, t_start: f32, t_span: f32) -> gpu_structs::Curve {
    let bounds = &curve.bounds;
    gpu_structs::Curve {
        b0: curve.b0.to_array(),
        r0: curve.r0,
        b2: curve.b2.to_array(),
        e0: curve.e0,
        d0: curve.d0.to_array(),
        ar: curve.ar,
        d1: curve.d1.to_array(),
        alpha: curve.alpha,
        a: curve.a.to_array(),
        beta: curve.beta,
        n_hat: curve.n_hat.to_array(),
        t_start,
        box_center: bounds.center.to_array(),
        t_span,
        box_axis_0: bounds.axes[0].to_array(),
        box_half_0: bounds.half[0],
        box_axis_1: bounds.axes[1].to_array(),
        box_half_1: bounds.half[1],
        box_axis_2: bounds.axes[2].to_array(),
        box_half_2: bounds.half[2],
    }
}

/// Values of a BendyLight that are compiled into the shaders that evaluate it; see the constants of `tube.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Baked {
    segments: usize,
    end_mode: EndMode,
    frame: FrameMode,
    direction: DirectionMode,
    /// True if the light's irradiance depends on the length of the light path.
    path_length: bool,
    /// True if the shadow map has the faces of a cube.
    cube: bool,
    light_profile: BakedFilter,
    filter: ShadowFilter,
}

impl Baked {
    /// Largest number of segments that `tube.wgsl` visits without a loop.
    const MAX_UNROLLED_SEGMENTS: usize = 6;

    pub fn of(tube: &Tube<f64>, cube: bool, filter: ShadowFilter) -> Self {
        Self {
            segments: if tube.n <= Self::MAX_UNROLLED_SEGMENTS { tube.n } else { 0 },
            end_mode: tube.end_mode(),
            frame: tube.frame,
            direction: tube.direction,
            path_length: tube.light_profile.needs_distance(),
            cube,
            light_profile: BakedFilter::of(&tube.light_profile),
            filter,
        }
    }

    /// Returns sets of values in which each field has each of its values at least once.
    #[cfg(test)]
    pub fn samples() -> [Self; 4] {
        let [light_profile, unshadowed, section, cut] = BakedFilter::samples();
        let plain = Self {
            segments: 3,
            end_mode: EndMode::Cut,
            frame: FrameMode::RotationMinimizing,
            direction: DirectionMode::Tube,
            path_length: false,
            cube: false,
            light_profile,
            filter: ShadowFilter::Nearest,
        };
        let long = Self { end_mode: EndMode::Extend, path_length: true, cube: true, ..plain };
        [
            plain,
            Self { light_profile: unshadowed, ..plain },
            Self {
                segments: 6,
                frame: FrameMode::Up,
                direction: DirectionMode::Path,
                filter: ShadowFilter::Bilinear,
                light_profile: section,
                ..long
            },
            Self { segments: 0, filter: ShadowFilter::Pcf3x3, light_profile: cut, ..long },
        ]
    }

    /// Prepends the constants of `tube.wgsl` to `wgsl`.
    pub fn into_wgsl(self, wgsl: &str) -> String {
        let Self { segments, end_mode, frame, direction, path_length, cube, light_profile, filter } = self;
        let constants = format!(
            "const BAKED_SEGMENTS = {segments}u;\nconst EXTENDED = {};\nconst FRAME_UP = {};\nconst DIRECTION_PATH = {};\n\
             const PATH_LENGTH = {path_length};\nconst SHADOW_CUBE = {cube};\n",
            end_mode == EndMode::Extend,
            frame == FrameMode::Up,
            direction == DirectionMode::Path,
        );
        constants + &light_profile.into_wgsl(&with_filter(filter, wgsl))
    }
}

/// Returns the tube's segments for `tube.wgsl`, padded to the size of its array.
pub(crate) fn segments(tube: &Tube<f64>) -> Vec<gpu_structs::Segment> {
    let one = |(i, segment): (usize, &Segment<f64>)| {
        let s = segment.to_f32();
        let bound = |x: f32| x.clamp(-MAX_INTENSITY, MAX_INTENSITY);
        let [color_0, color_1, color_2] = s.color.map(|c| c.to_array().map(bound));
        let [intensity_0, intensity_1, intensity_2] = s.intensity.map(bound);
        gpu_structs::Segment {
            curve: gpu_curve(&s.curve, i as f32, 1.0),
            color_0,
            intensity_0,
            color_1,
            intensity_1,
            color_2,
            intensity_2,
            arc_start: s.arc_start,
            pad0: [0.0; 3],
        }
    };
    let mut segments: Vec<_> = tube.segments.iter().enumerate().map(one).collect();
    segments.resize(SEGMENT_CAPACITY, gpu_structs::Segment::default());
    segments
}

/// Returns the light's uniform for `tube.wgsl`, without the fields of its shadow map.
pub(crate) fn uniform(part: &LightPart, scene_origin: DVec3) -> gpu_structs::BendyLight {
    let tube = &part.tube;
    let rotation = tube.placement.rotation.as_mat3();
    gpu_structs::BendyLight {
        tube_from_scene: tube_from_scene(tube, scene_origin),
        world_from_tube: [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|c| c.extend(0.0).to_array()),
        up: tube.up.as_vec3().to_array(),
        segment_count: tube.n as u32,
        world_per_tube: tube.placement.world_per_tube as f32,
        t_start: part.t_start as f32,
        t_span: part.t_span as f32,
        light_profile: (&tube.light_profile).into(),
        ..gpu_structs::BendyLight::default()
    }
}

/// Returns the mesh error in tube space, at most the extent of the scene: a larger one has the same effect.
fn mesh_error_in_tube(tube: &Tube<f64>, map: &MapShape) -> f32 {
    (map.mesh_error / tube.placement.world_per_tube).min(MAX_EXTENT) as f32
}

/// Returns the light's uniform for `tube.wgsl`, with its shadow map.
pub(crate) fn uniform_with_map(
    part: &LightPart,
    scene_origin: DVec3,
    map: &MapShape,
    shadows: &ShadowSettings,
) -> gpu_structs::BendyLight {
    gpu_structs::BendyLight {
        map_t_base: map.t_base() as f32,
        map_t_span: map.t_span() as f32,
        map_t_last: map.t_last() as f32,
        slope: map.slope() as f32,
        shadow_resolution: map.side as f32,
        shadow_tolerance_texels: shadows.bent_tolerance_texels(),
        mesh_error: mesh_error_in_tube(&part.tube, map),
        fits: map.fits(),
        ..uniform(part, scene_origin)
    }
}

//! BendyLights on the GPU: the tube as buffers, bent shadow maps, and location of points.

mod alpha_tested_draw;
pub(crate) mod bent_map;
pub(crate) mod gpu_structs;
mod pass;
mod shadow_buffers;
pub(crate) mod slab;
#[cfg(test)]
pub(crate) mod tests;
#[cfg(test)]
pub(crate) mod walk;
mod wireframe;

use light::{Curve, DirectionMode, EndMode, FrameMode, Segment, Tube};
use shadow::PlacedBent;

use crate::ShadowFilter;
use crate::wgpu::baked_filter::{BakedFilter, with_filter};

pub(crate) use pass::BendyPass;
pub(crate) use shadow_buffers::BentMapBuffers;

/// Length of the arrays of faces in the shaders.
const MAX_FACES: usize = 5;
/// Length of the array of segments in `tube.wgsl`: the most segments of a light, and the extension.
const SEGMENT_CAPACITY: usize = light::MAX_SEGMENTS + 1;

/// Largest color and intensity. Their product is finite in f32, and `profile.wgsl` keeps its product with exposure,
/// decay and the BRDF within f32.
const MAX_INTENSITY: f32 = 1e15;

pub(crate) fn gpu_curve(curve: &Curve<f32>, t_start: f32, t_span: f32) -> gpu_structs::Curve {
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

/// Returns the uniform of a light for `tube.wgsl`.
pub(crate) fn uniform(placed: &PlacedBent) -> gpu_structs::BendyLight {
    let PlacedBent { part, tube_from_scene, shape, map } = placed;
    let tube = &part.tube;
    let rotation = tube.placement.rotation.as_mat3();
    gpu_structs::BendyLight {
        tube_from_scene: tube_from_scene.to_cols_array_2d(),
        world_from_tube: [rotation.x_axis, rotation.y_axis, rotation.z_axis].map(|c| c.extend(0.0).to_array()),
        up: tube.up.as_vec3().to_array(),
        segment_count: tube.n as u32,
        world_per_tube: tube.placement.world_per_tube as f32,
        map_t_base: map.t_base,
        map_t_span: map.t_span,
        map_t_last: map.t_last,
        slope: map.slope.unwrap_or(1.0),
        shadow_resolution: shape.as_ref().map_or(0, |shape| shape.side) as f32,
        shadow_tolerance_texels: map.tolerance_texels,
        mesh_error: map.mesh_error,
        t_start: part.t_start as f32,
        t_span: part.t_span as f32,
        pad0: [0.0; 2],
        light_profile: (&tube.light_profile).into(),
        fits: map.fits,
    }
}

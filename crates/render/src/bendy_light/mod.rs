//! A BendyLight on the GPU: its tube as buffers, its bent shadow map, and points located in it.

mod faces;
mod fit;
pub(crate) mod layout;
mod locate;
mod map_shape;
mod mapped;
mod masked;
mod pass;
mod shadow;
mod slab;
mod solve;
#[cfg(test)]
pub(crate) mod tests;
#[cfg(test)]
pub(crate) mod walk;
mod wireframe;

use glam::{DMat3, DMat4, DVec3};
use light::MAX_EXTENT;
use light::{Decay, Direction, EndMode, Frame, Part, Segment, Tube};

use self::map_shape::MapShape;
use crate::layout::Mat4;
use crate::{ShadowFilter, ShadowSettings};

pub(crate) use faces::map_size;
pub use locate::locate;
pub use mapped::map_points;
pub(crate) use pass::{BendyPass, BendySlot};
pub(crate) use shadow::BentWork;
pub use solve::increasing_roots;

/// Length of the array of segments in `tube.wgsl`: all that a light may have, and the extension.
const SEGMENT_ROOM: usize = light::MAX_SEGMENTS + 1;

/// Largest colour and intensity: their product is still finite in f32; `tube.wgsl` then keeps it, decay and
/// the BRDF within f32.
const MAX_INTENSITY: f32 = 1e15;

/// Columns of the matrix from scene space (world axes about `scene_origin`) to tube space, composed in f64.
fn tube_from_scene(tube: &Tube<f64>, scene_origin: DVec3) -> Mat4 {
    let placement = &tube.placement;
    let rotation =
        placement.rotation.transpose() * DMat3::from_diagonal(DVec3::splat(1.0 / placement.world_per_tube));
    let offset = placement.tube_from_world(scene_origin);
    let matrix = DMat4::from_cols(
        rotation.x_axis.extend(0.0),
        rotation.y_axis.extend(0.0),
        rotation.z_axis.extend(0.0),
        offset.extend(1.0),
    );
    matrix.as_mat4().to_cols_array_2d()
}

/// The greatest t that anything within `half_extent` of the scene's origin can have: the end of the light, or
/// of what it can reach where it is extended.
pub(crate) fn t_max(tube: &Tube<f64>, scene_origin: DVec3, half_extent: DVec3) -> f64 {
    let n = tube.n as f64;
    if tube.end_mode() == EndMode::Cut {
        return n;
    }
    let last = &tube.segments[tube.n];
    let farthest = corners(scene_origin, half_extent)
        .map(|corner| (tube.placement.tube_from_world(corner) - last.b0).dot(last.d0))
        .fold(0.0, f64::max);
    // A hundredth more, so that the far corner itself is inside.
    n + (farthest / (2.0 * last.d0.length_squared())) * 1.01 + 1e-3
}

/// World corners of the scene's bounds.
fn corners(scene_origin: DVec3, half_extent: DVec3) -> impl Iterator<Item = DVec3> {
    (0..8).map(move |k| {
        let sign = DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2 & 1)) * 2.0 - 1.0;
        scene_origin + half_extent * sign
    })
}

/// World points around the tube up to `t_max`: the corners of its slabs' boxes.
pub(crate) fn hull_in_world(tube: &Tube<f64>, t_max: f64) -> Vec<DVec3> {
    light::slabs(tube, t_max, 0.0)
        .iter()
        .flat_map(|slab| slab.piece.bounds.corners())
        .map(|corner| tube.placement.world_from_tube(corner))
        .collect()
}

fn curve(segment: &Segment<f32>, t_start: f64, t_span: f64) -> layout::Curve {
    let bounds = &segment.bounds;
    layout::Curve {
        b0: segment.b0.to_array(),
        r0: segment.r0,
        b2: segment.b2.to_array(),
        e0: segment.e0,
        d0: segment.d0.to_array(),
        ar: segment.ar,
        d1: segment.d1.to_array(),
        alpha: segment.alpha,
        a: segment.a.to_array(),
        beta: segment.beta,
        n_hat: segment.n_hat.to_array(),
        t_start: t_start as f32,
        box_center: bounds.center.to_array(),
        t_span: t_span as f32,
        box_axis_0: bounds.axes[0].to_array(),
        box_half_0: bounds.half[0],
        box_axis_1: bounds.axes[1].to_array(),
        box_half_1: bounds.half[1],
        box_axis_2: bounds.axes[2].to_array(),
        box_half_2: bounds.half[2],
    }
}

/// What is compiled into the shaders that evaluate a light: see the constants of `tube.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Baked {
    segments: usize,
    end_mode: EndMode,
    frame: Frame,
    direction: Direction,
    decay: Decay,
    /// Whether the shadow map has the faces of a cube.
    cube: bool,
    filter: ShadowFilter,
}

impl Baked {
    /// Most segments that are visited in straight code: `tube.wgsl` spells them out.
    const MOST_SEGMENTS: usize = 6;

    /// How many values there are.
    pub const COUNT: usize = (Self::MOST_SEGMENTS + 1) * 2 * 2 * 2 * 3 * 2 * 3;

    /// Numbers the values from 0.
    pub fn index(self) -> usize {
        let Self { segments, end_mode, frame, direction, decay, cube, filter } = self;
        let digits = [
            (2, end_mode as usize),
            (2, frame as usize),
            (2, direction as usize),
            (3, decay as usize),
            (2, usize::from(cube)),
            (3, filter as usize),
        ];
        digits.into_iter().fold(segments, |index, (values, value)| index * values + value)
    }

    pub fn of(tube: &Tube<f64>, cube: bool, filter: ShadowFilter) -> Self {
        Self {
            segments: if tube.n <= Self::MOST_SEGMENTS { tube.n } else { 0 },
            end_mode: tube.end_mode(),
            frame: tube.frame,
            direction: tube.direction,
            decay: tube.decay,
            cube,
            filter,
        }
    }

    /// Each value of each field at least once.
    #[cfg(test)]
    pub fn samples() -> [Self; 3] {
        let one = |segments, end_mode, frame, direction, decay, cube, filter| Self {
            segments,
            end_mode,
            frame,
            direction,
            decay,
            cube,
            filter,
        };
        [
            one(
                3,
                EndMode::Cut,
                Frame::RotationMinimizing,
                Direction::Tube,
                Decay::None,
                false,
                ShadowFilter::Nearest,
            ),
            one(
                6,
                EndMode::Extend,
                Frame::Up,
                Direction::Path,
                Decay::InverseSquare,
                true,
                ShadowFilter::Bilinear,
            ),
            one(
                0,
                EndMode::Extend,
                Frame::RotationMinimizing,
                Direction::Tube,
                Decay::Linear,
                true,
                ShadowFilter::Pcf3x3,
            ),
        ]
    }

    /// `wgsl` with the constants that `tube.wgsl` asks for.
    pub fn into_wgsl(self, wgsl: &str) -> String {
        let Self { segments, end_mode, frame, direction, decay, cube, filter } = self;
        let decay = match decay {
            Decay::None => 0,
            Decay::Linear => 1,
            Decay::InverseSquare => 2,
        };
        let constants = format!(
            "const BAKED_SEGMENTS = {segments}u;\nconst EXTENDED = {};\nconst FRAME_UP = {};\nconst DIRECTION_PATH = {};\n\
             const DECAY = {decay}u;\nconst SHADOW_CUBE = {cube};\n",
            end_mode == EndMode::Extend,
            frame == Frame::Up,
            direction == Direction::Path,
        );
        constants + &filter.into_wgsl(wgsl)
    }
}

/// The tube's segments for `tube.wgsl`, filled up to the size of its array.
pub(crate) fn segments(tube: &Tube<f64>) -> Vec<layout::Segment> {
    let one = |(i, segment): (usize, &Segment<f64>)| {
        let s = segment.to_f32();
        let bound = |x: f32| x.clamp(-MAX_INTENSITY, MAX_INTENSITY);
        let [color_0, color_1, color_2] = s.color.map(|c| c.to_array().map(bound));
        let [intensity_0, intensity_1, intensity_2] = s.intensity.map(bound);
        layout::Segment {
            curve: curve(&s, i as f64, 1.0),
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
    segments.resize(SEGMENT_ROOM, layout::Segment::default());
    segments
}

/// The light's uniform for `tube.wgsl`, but for what says of its shadow map.
pub(crate) fn uniform(part: &Part, scene_origin: DVec3) -> layout::BendyLight {
    let tube = &part.tube;
    let rotation = tube.placement.rotation.as_mat3();
    let f32_tube = Tube::<f32>::from(tube);
    layout::BendyLight {
        tube_from_scene: tube_from_scene(tube, scene_origin),
        world_from_tube: [rotation.x_axis, rotation.y_axis, rotation.z_axis]
            .map(|c| c.extend(0.0).to_array()),
        up: f32_tube.up.to_array(),
        segment_count: tube.n as u32,
        world_per_tube: tube.placement.world_per_tube as f32,
        tan2_outer: f32_tube.profile.tan2_outer,
        cos_outer: f32_tube.profile.cos_outer,
        inv_cos_range: f32_tube.profile.inv_cos_range,
        t_start: part.t_start as f32,
        t_span: part.t_span as f32,
        least_distance2: f32_tube.least_distance2,
        ..layout::BendyLight::default()
    }
}

/// The same with its shadow map.
pub(crate) fn uniform_with_map(
    part: &Part,
    scene_origin: DVec3,
    map: &MapShape,
    shadows: &ShadowSettings,
) -> layout::BendyLight {
    layout::BendyLight {
        map_t_base: map.t_base() as f32,
        map_t_span: map.t_span() as f32,
        map_t_last: map.t_last() as f32,
        slope: map.slope() as f32,
        shadow_resolution: map.side() as f32,
        shadow_tolerance_texels: shadows.bent_tolerance_texels(),
        // Farther than the scene reaches is as good as any farther.
        mesh_error: (shadows.mesh_error / part.tube.placement.world_per_tube).min(MAX_EXTENT) as f32,
        fits: map.fits(),
        ..uniform(part, scene_origin)
    }
}

//! Structs of the bent passes, in WGSL layout.

use super::MAX_FACES;
use crate::wgpu::gpu_structs::{LightProfile, Mat4, gpu_structs};

/// Columns of a 3 x 3 matrix, each followed by padding.
pub(crate) type Mat3 = [[f32; 4]; 3];

/// Returns the columns of a matrix, each followed by padding.
pub(super) fn columns(matrix: &glam::Mat3) -> Mat3 {
    matrix.to_cols_array_2d().map(|[x, y, z]| [x, y, z, 0.0])
}

gpu_structs! {
    /// Quadratic piece of a tube in `curve.wgsl`: `light::Curve` in f32.
    Curve {
        b0: [f32; 3],
        r0: f32,
        b2: [f32; 3],
        e0: f32,
        d0: [f32; 3],
        ar: f32,
        d1: [f32; 3],
        alpha: f32,
        a: [f32; 3],
        beta: f32,
        n_hat: [f32; 3],
        t_start: f32,
        box_center: [f32; 3],
        t_span: f32,
        box_axis_0: [f32; 3],
        box_half_0: f32,
        box_axis_1: [f32; 3],
        box_half_1: f32,
        box_axis_2: [f32; 3],
        box_half_2: f32,
    }

    /// Segment of a BendyLight in `tube.wgsl`: its curve, and the control values of color and intensity.
    Segment {
        curve: Curve,
        color_0: [f32; 3],
        intensity_0: f32,
        color_1: [f32; 3],
        intensity_1: f32,
        color_2: [f32; 3],
        intensity_2: f32,
        arc_start: f32,
        pad0: [f32; 3],
    }

    /// Uniform of a BendyLight in `tube.wgsl`, with the parameters of its shadow map.
    BendyLight {
        tube_from_scene: Mat4,
        world_from_tube: Mat3,
        up: [f32; 3],
        segment_count: u32,
        world_per_tube: f32,
        map_t_base: f32,
        map_t_span: f32,
        map_t_last: f32,
        slope: f32,
        shadow_resolution: f32,
        shadow_tolerance_texels: f32,
        mesh_error: f32,
        t_start: f32,
        t_span: f32,
        pad0: [f32; 2],
        light_profile: LightProfile,
        fits: [[f32; 4]; MAX_FACES],
    }

    /// Root of a point in a tube, as `locate.wgsl` writes it.
    LocatedRoot {
        segment: u32,
        u: f32,
        v_len: f32,
        w_len: f32,
        radius: f32,
        pad0: [f32; 3],
        direction: [f32; 3],
        pad1: f32,
    }

    /// Uniform of the compute passes that map casters into a tube, in `bent_map.wgsl`.
    BentMap {
        tube_from_scene: Mat4,
        up: [f32; 3],
        frame_up: u32,
        box_min: [f32; 3],
        slab_count: u32,
        box_max: [f32; 3],
        vertex_count: u32,
        block_count: u32,
        face_count: u32,
        work_capacity: u32,
        patch_capacity: u32,
        split_capacity: u32,
        tolerance_texels: f32,
        texels_per_vw: f32,
        cube_slope: f32,
        opaque_triangles: u32,
        masked_capacity: u32,
        pad0: [f32; 2],
        faces: [Mat3; MAX_FACES],
    }

    /// Slab of a tube in `bent_map.wgsl`: a piece of its curve, between planes.
    Slab {
        curve: Curve,
        planes: [[f32; 4]; 6],
        edge_bounds: [f32; 4],
    }

    /// Counts of mapped triangles in `bent_map.wgsl`, which the compute passes increase. They begin with the arguments
    /// of the indirect draws.
    BentCounts {
        whole_index_count: u32,
        whole_instance_count: u32,
        whole_first_index: u32,
        whole_base_vertex: u32,
        whole_first_instance: u32,
        split_vertex_count: u32,
        split_instance_count: u32,
        split_first_vertex: u32,
        split_first_instance: u32,
        masked_vertex_count: u32,
        masked_instance_count: u32,
        masked_first_vertex: u32,
        masked_first_instance: u32,
        level: u32,
        items: [u32; LEVELS],
    }

    /// Part of a triangle in one slab, in `bent_map.wgsl`: its corners in tube space and in tube coordinates.
    Patch {
        a: [f32; 3],
        slab: u32,
        b: [f32; 3],
        caster: u32,
        c: [f32; 3],
        pad0: f32,
        mapped_a: [f32; 4],
        mapped_b: [f32; 4],
        mapped_c: [f32; 4],
    }

    /// Uniform for drawing mapped triangles onto one face of a bent shadow map, in `bent_shadow.wgsl`.
    BentShadow {
        clip_from_mapped: Mat3,
        row: [f32; 2],
        depth_per_t: f32,
        pad0: f32,
    }

    /// Uniform for drawing mapped triangles as a wireframe, in `wireframe.wgsl`.
    Wireframe {
        clip_per_vw: [f32; 2],
        t_start: f32,
        t_span: f32,
        map_t_base: f32,
        map_t_span: f32,
    }
}

/// Number of compute passes, each of which works on the items that the one before wrote: clipping, ten levels of
/// splitting, and a last one that only draws.
pub(crate) const LEVELS: usize = 12;

//! The structs that Rust and WGSL share. A test holds every name and offset against the WGSL.

/// Declares a struct as WGSL lays it out. Fields whose names begin with `pad` are gaps that WGSL leaves by
/// itself.
macro_rules! gpu_struct {
    ($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty,)* }) => {
        $(#[$doc])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
        pub(crate) struct $name {
            $(pub $field: $type,)*
        }

        #[cfg(test)]
        impl $name {
            /// Name, size, and the name and offset of each field.
            pub const LAYOUT: $crate::gpu_structs::StructLayout = (
                stringify!($name),
                size_of::<$name>(),
                &[$((stringify!($field), std::mem::offset_of!($name, $field)),)*],
            );
        }
    };
}

pub(crate) use gpu_struct;

/// Name, size, and the name and offset of each field.
#[cfg(test)]
pub(crate) type StructLayout = (&'static str, usize, &'static [(&'static str, usize)]);

/// Every struct of this file; the layout test walks it.
#[cfg(test)]
pub(crate) const ALL: &[StructLayout] = &[
    View::LAYOUT,
    Material::LAYOUT,
    AlphaTest::LAYOUT,
    Fill::LAYOUT,
    ShadowView::LAYOUT,
    LightFilter::LAYOUT,
    Spot::LAYOUT,
    HierarchyNode::LAYOUT,
];

/// Columns of a 4 x 4 matrix.
pub(crate) type Mat4 = [[f32; 4]; 4];

gpu_struct! {
    /// See `view.wgsl`.
    View {
        clip_from_scene: Mat4,
        ray_origin: [f32; 3],
        sample_weight: f32,
        ray_origin_dx: [f32; 3],
        fill_factor: f32,
        ray_origin_dy: [f32; 3],
        pad0: f32,
        ray_direction: [f32; 3],
        pad1: f32,
        ray_direction_dx: [f32; 3],
        pad2: f32,
        ray_direction_dy: [f32; 3],
        pad3: f32,
        depth_from_z: [f32; 4],
        tile_origin: [f32; 2],
        pad4: [f32; 2],
    }
}

gpu_struct! {
    /// See `nearby.wgsl`.
    HierarchyNode {
        min: [f32; 3],
        triangle_count: u32,
        max: [f32; 3],
        next: u32,
    }
}

gpu_struct! {
    /// See `material.wgsl`.
    Material {
        base_color: [f32; 4],
        metallic: f32,
        roughness: f32,
        alpha_cutoff: f32,
        first_triangle: u32,
    }
}

gpu_struct! {
    /// See `alpha_test.wgsl`.
    AlphaTest {
        first_triangle: u32,
        first_index: u32,
        cutoff: f32,
        factor: f32,
        offset: u32,
        width: u32,
        height: u32,
        levels: u32,
        wrap_u: u32,
        wrap_v: u32,
        nearest: u32,
    }
}

gpu_struct! {
    /// See `fill.wgsl`.
    Fill {
        sky: [f32; 3],
        pad0: f32,
        ground: [f32; 3],
        pad1: f32,
    }
}

gpu_struct! {
    /// See `shadow.wgsl`.
    ShadowView {
        clip_from_scene: Mat4,
    }
}

/// Length of the array of faces in `spot.wgsl`.
pub(crate) const SPOT_FACES: usize = 5;

gpu_struct! {
    /// See `filter.wgsl`.
    LightFilter {
        decay: [f32; 3],
        least_distance: f32,
        tan2_outer: f32,
        edge: f32,
        inverse_span: f32,
        exposure: f32,
    }
}

impl From<&light::LightFilter> for LightFilter {
    fn from(filter: &light::LightFilter) -> Self {
        let light::LightFilter { exposure, profile, decay, least_distance } = filter;
        // A profile that steep is a step, in single precision too.
        let inverse_span = profile.inverse_span.min(1e30);
        Self {
            decay: decay.weights().map(|weight| weight as f32),
            least_distance: *least_distance as f32,
            tan2_outer: profile.tan2_outer as f32,
            edge: profile.edge as f32,
            inverse_span: inverse_span as f32,
            exposure: *exposure as f32,
        }
    }
}

gpu_struct! {
    /// See `cone.wgsl`.
    Spot {
        light_from_scene: Mat4,
        emission: [f32; 3],
        tan_outer: f32,
        light_filter: LightFilter,
        range: f32,
        shadow_near: f32,
        mesh_error: f32,
        pad0: f32,
        fits: [[f32; 4]; SPOT_FACES],
    }
}

//! Structs that Rust and WGSL share. A test compares every name and offset with the WGSL.

use glam::DVec3;

use crate::frame::TERMS;
use crate::frame::camera::SampleView;

/// Declares structs in WGSL layout. Fields whose names begin with `pad` are gaps that WGSL adds by itself.
macro_rules! gpu_structs {
    ($($(#[$doc:meta])* $name:ident { $($field:ident: $type:ty,)* })*) => {
        $(
            $(#[$doc])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
            pub(crate) struct $name {
                $(pub $field: $type,)*
            }
        )*

        /// Layouts of all these structs.
        #[cfg(test)]
        pub(crate) const LAYOUTS: &[$crate::wgpu::gpu_structs::StructLayout] = &[$((
            stringify!($name),
            size_of::<$name>(),
            &[$((stringify!($field), std::mem::offset_of!($name, $field)),)*],
        ),)*];
    };
}

pub(crate) use gpu_structs;

/// Name, size, and the name and offset of each field.
#[cfg(test)]
pub(crate) type StructLayout = (&'static str, usize, &'static [(&'static str, usize)]);

/// Columns of a 4 x 4 matrix.
pub(crate) type Mat4 = [[f32; 4]; 4];

gpu_structs! {
    /// Uniform of a view in `view.wgsl`: the camera, and the rays through the pixels of a picture.
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

    /// Uniform of a glTF material in `material.wgsl`, without its textures.
    Material {
        base_color: [f32; 4],
        metallic: f32,
        roughness: f32,
        alpha_cutoff: f32,
        pad0: f32,
    }

    /// Alpha test of a material's triangles in `alpha_test.wgsl`: the triangles, the cutoff, and the offset, size and
    /// wrap modes of the texture, which lies in one buffer with all others.
    AlphaTest {
        first_triangle: u32,
        first_index: u32,
        cutoff: f32,
        factor: f32,
        offset: u32,
        width: u32,
        height: u32,
        wrap_u: u32,
        wrap_v: u32,
        nearest: u32,
    }

    /// Uniform of the scene's fill light in `fill.wgsl`: a hemisphere from `ground` to `sky`.
    Fill {
        sky: [f32; 3],
        pad0: f32,
        ground: [f32; 3],
        pad1: f32,
    }

    /// Uniform of the exposure in `display.wgsl`.
    Exposure {
        factor: f32,
        brightest: f32,
    }

    /// Uniform of one face of a straight light's shadow map in `shadow.wgsl`.
    ShadowView {
        clip_from_scene: Mat4,
    }

    /// Falloff of a light in `profile.wgsl`: `light::LightProfile` in f32.
    LightProfile {
        tint: [f32; 3],
        least_distance: f32,
        decay: [f32; 3],
        profile_power: f32,
        shadow_color: [f32; 3],
        tan2_outer: f32,
        lobes: [f32; 2],
        edge: f32,
        inverse_span: f32,
        cut_starts: [f32; 2],
        cut_inverse_widths: [f32; 2],
        section_scale: [f32; 2],
        section_power: f32,
        pad0: f32,
        radial: [[f32; 4]; RADIAL_PIECES],
    }

    /// Uniform of a sum of layers in `terms.wgsl`: the number of terms, and the factors of each.
    Terms {
        diffuse: [[f32; 4]; TERMS],
        specular: [[f32; 4]; TERMS],
        count: u32,
        pad0: [u32; 3],
    }

    /// Uniform of a spotlight in `cone.wgsl`.
    Spot {
        light_from_scene: Mat4,
        light_profile: LightProfile,
        tan_outer: f32,
        range: f32,
        shadow_near: f32,
        mesh_error: f32,
        fits: [[f32; 4]; SPOT_FACES],
    }

    /// Uniform of an omni light in `omni.wgsl`.
    Omni {
        light_from_scene: Mat4,
        light_profile: LightProfile,
        range: f32,
        shadow_near: f32,
        mesh_error: f32,
        pad0: f32,
        fits: [[f32; 4]; OMNI_FACES],
    }

    /// Uniform of a directional light in `parallel.wgsl`.
    Directional {
        light_from_scene: Mat4,
        window: [f32; 4],
        fit: [f32; 4],
        light_profile: LightProfile,
        bottom: f32,
        depth_scale: f32,
        mesh_error: f32,
        pad0: f32,
    }
}

/// Length of the array of faces in `omni.wgsl`.
pub(crate) const OMNI_FACES: usize = 6;

/// Length of the array of faces in `spot.wgsl`.
pub(crate) const SPOT_FACES: usize = 5;

/// Length of the array of pieces in `profile.wgsl`: one more than the most knots.
pub(crate) const RADIAL_PIECES: usize = light::MAX_KNOTS + 1;

/// Piece of a periodic curve that fills unused entries: it begins beyond all angles.
const NO_PIECE: [f32; 4] = [LARGE as f32, 1.0, 1.0, 0.0];

/// Limit for numbers that f64 can hold and f32 cannot. A ramp as steep as this is a step in f32, and `profile.wgsl`
/// keeps light as strong as this within f32.
pub(crate) const LARGE: f64 = 1e30;

impl From<&light::LightProfile> for LightProfile {
    fn from(filter: &light::LightProfile) -> Self {
        let light::LightProfile {
            tint,
            diffuse,
            specular,
            shadow_color,
            profile,
            section,
            radial,
            decay,
            distance_ramps: cut,
            ..
        } = filter;
        let (section_scale, section_power) = match *section {
            light::SectionOutline::Circle => ([1.0; 2], 2.0),
            light::SectionOutline::Superellipse { scale, power } => (scale, power),
        };
        let mut pieces = [NO_PIECE; RADIAL_PIECES];
        for (slot, piece) in pieces.iter_mut().zip(&radial.pieces) {
            let [from, to] = piece.values;
            *slot = [piece.start_degrees, from, to, piece.inverse_length].map(|value| value.min(LARGE) as f32);
        }
        let f32s = |values: [f64; 2]| values.map(|value| value.clamp(-LARGE, LARGE) as f32);
        Self {
            tint: tint.min(DVec3::splat(LARGE)).as_vec3().to_array(),
            least_distance: filter.min_distance.min(LARGE) as f32,
            decay: decay.denominator_coefficients().map(|weight| weight as f32),
            shadow_color: shadow_color.min(DVec3::splat(LARGE)).as_vec3().to_array(),
            profile_power: profile.power as f32,
            lobes: f32s([*diffuse, *specular]),
            tan2_outer: profile.tan2_outer as f32,
            edge: profile.edge as f32,
            cut_starts: f32s([cut.on_start, cut.off_start]),
            cut_inverse_widths: f32s([cut.on_inverse_width, cut.off_inverse_width]),
            section_scale: f32s(section_scale),
            section_power: section_power.min(LARGE) as f32,
            pad0: 0.0,
            radial: pieces,
            inverse_span: profile.inverse_span.min(LARGE) as f32,
        }
    }
}

impl From<&SampleView> for View {
    fn from(view: &SampleView) -> Self {
        Self {
            clip_from_scene: view.clip_from_scene.to_cols_array_2d(),
            ray_origin: view.ray_origin,
            sample_weight: view.weight,
            ray_origin_dx: view.ray_origin_dx,
            fill_factor: view.fill_factor,
            ray_origin_dy: view.ray_origin_dy,
            ray_direction: view.ray_direction,
            ray_direction_dx: view.ray_direction_dx,
            ray_direction_dy: view.ray_direction_dy,
            depth_from_z: view.depth_from_z,
            tile_origin: view.tile_origin,
            ..Self::default()
        }
    }
}

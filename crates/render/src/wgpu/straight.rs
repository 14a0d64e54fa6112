//! Lighting of lights with straight rays, whose maps are drawn with ordinary matrices.

use shadow::{PlacedStraight, StraightCoords};
use wgpu::{BindGroup, BindGroupLayout, BindingType, BufferUsages};

use crate::wgpu::baked_filter::{BakedFilter, with_filter};
use crate::wgpu::gpu_structs;
use crate::wgpu::lighting::{LightConstants, LightPasses};
use crate::wgpu::pipeline::{MapTarget, NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM};
use crate::wgpu::scene::SceneGroupLayouts;
use crate::wgpu::shaders;
use crate::wgpu::straight_map::ShadowPass;
use crate::{Gpu, ShadowFilter};

/// Bindings of group 2 in the lighting passes of straight lights; see `spot.wgsl`.
const BINDINGS: [BindingType; 3] = [UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// Values of a light that are compiled into its lighting pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BakedStraight {
    shape: BakedShape,
    filter: ShadowFilter,
    light_profile: BakedFilter,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum BakedShape {
    Spot {
        /// True if the map has the faces of a cube; see `spot_faces.wgsl`.
        cube: bool,
    },
    Omni,
    Directional,
}

impl BakedStraight {
    /// Returns the values of a light whose map has several faces if `cube`.
    pub fn of(placed: &PlacedStraight, cube: bool) -> Self {
        let (shape, filter) = match &placed.coords {
            StraightCoords::Spot { map, .. } => (BakedShape::Spot { cube }, map.filter),
            StraightCoords::Omni { map, .. } => (BakedShape::Omni, map.filter),
            StraightCoords::Directional { map, .. } => (BakedShape::Directional, map.filter),
        };
        Self { shape, filter, light_profile: BakedFilter::of(&placed.light_profile) }
    }

    #[cfg(test)]
    pub fn all() -> impl Iterator<Item = Self> {
        let with = |shape, filter, light_profile| Self { shape, filter, light_profile };
        let spot = |cube| BakedShape::Spot { cube };
        let [plain, rest @ ..] = BakedFilter::samples();
        let filters = ShadowFilter::ALL.into_iter();
        let spots = filters.clone().flat_map(move |filter| [false, true].map(|cube| with(spot(cube), filter, plain)));
        let spots = spots.chain(rest.map(|profile| with(spot(false), ShadowFilter::Nearest, profile)));
        let others = BakedFilter::samples().into_iter().zip(filters.cycle()).flat_map(move |(profile, filter)| {
            [BakedShape::Omni, BakedShape::Directional].map(|shape| with(shape, filter, profile))
        });
        spots.chain(others)
    }
}

impl LightConstants for BakedStraight {
    fn wgsl(self) -> (&'static str, String) {
        let with_constants = |wgsl| self.light_profile.into_wgsl(&with_filter(self.filter, wgsl));
        match self.shape {
            BakedShape::Spot { cube } => {
                ("spot", format!("const SHADOW_CUBE = {cube};\n{}", with_constants(shaders::SPOT)))
            }
            BakedShape::Omni => ("omni", with_constants(shaders::OMNI)),
            BakedShape::Directional => ("directional", with_constants(shaders::DIRECTIONAL)),
        }
    }
}

/// The pipelines of straight lights, shared by all scenes and lights.
#[derive(Debug)]
pub(crate) struct StraightPass {
    pub shadow: ShadowPass,
    pub lighting: LightPasses<BakedStraight>,
}

impl StraightPass {
    /// Compiles the pipelines. `camera_groups` are the layouts of the view and the surface.
    pub fn new(gpu: &Gpu, camera_groups: [&BindGroupLayout; 2], scene: &SceneGroupLayouts) -> Self {
        Self {
            shadow: ShadowPass::new(gpu, &scene.material),
            lighting: LightPasses::new(gpu, "straight light", &BINDINGS, camera_groups, &scene.links),
        }
    }

    /// Makes group 2 of the lighting pass of a light with its map.
    pub fn light_group(&self, gpu: &Gpu, placed: &PlacedStraight, map: &MapTarget) -> BindGroup {
        let bytes = match placed.coords {
            StraightCoords::Spot { tan_outer, range, map } => bytemuck::bytes_of(&gpu_structs::Spot {
                light_from_scene: placed.light_from_scene.as_mat4().to_cols_array_2d(),
                light_profile: (&placed.light_profile).into(),
                tan_outer,
                range: range.unwrap_or(0.0),
                shadow_near: map.near,
                mesh_error: map.mesh_error,
                fits: map.fits,
            })
            .to_vec(),
            StraightCoords::Omni { range, map } => bytemuck::bytes_of(&gpu_structs::Omni {
                light_from_scene: placed.light_from_scene.as_mat4().to_cols_array_2d(),
                light_profile: (&placed.light_profile).into(),
                range: range.unwrap_or(0.0),
                shadow_near: map.near,
                mesh_error: map.mesh_error,
                pad0: 0.0,
                fits: map.fits,
            })
            .to_vec(),
            StraightCoords::Directional { window, map } => bytemuck::bytes_of(&gpu_structs::Directional {
                light_from_scene: placed.light_from_scene.as_mat4().to_cols_array_2d(),
                window,
                fit: map.fit,
                light_profile: (&placed.light_profile).into(),
                bottom: map.bottom,
                depth_scale: map.depth_scale,
                mesh_error: map.mesh_error,
                pad0: 0.0,
            })
            .to_vec(),
        };
        let uniform = gpu.buffer_with("straight light", &bytes, BufferUsages::UNIFORM);
        self.lighting.light_group(gpu, &[&uniform], map)
    }
}

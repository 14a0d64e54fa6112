//! Lights with straight rays, whose maps are drawn with ordinary matrices. `spot.rs`, `omni.rs` and `directional.rs`
//! place, fit and look up each shape.

use std::sync::Arc;

use glam::DVec3;
use light::{CheckedLight, Cone, LightProfile, LightRays, Omni, Parallel};
use scene::PosedScene;
use wgpu::util::{BufferInitDescriptor, DeviceExt};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, CommandEncoder, Sampler};

use crate::baked_filter::BakedFilter;
use crate::directional::{self, DirectionalMapFit, GpuDirectional};
use crate::gpu_scene::{GpuScene, SceneGroupLayouts};
use crate::lighting::{LightingPass, PassVariants};
use crate::linked::{LinkedCasters, caster_set};
use crate::map_key::MapKey;
use crate::map_views::MapViews;
use crate::omni::{self, GpuOmni};
use crate::omni_faces::FittedCube;
use crate::pipeline::{NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM};
use crate::shadow::{ShadowMap, ShadowPass};
use crate::shadow_settings::{MapSize, with_filter};
use crate::spot::{self, BakedSpot, GpuSpot};
use crate::spot_faces::FittedFaces;
use crate::stages::FrameStage;
use crate::{Gpu, RenderError, ShadowFilter, ShadowSettings, shaders};

/// Bindings of group 2 in the lighting passes of straight lights; see `spot.wgsl`.
const BINDINGS: [BindingType; 3] = [UNIFORM, RAW_TEXTURE_LAYERS, NON_FILTERING];

/// A checked light with straight rays.
#[derive(Clone, Copy, Debug)]
pub(crate) enum StraightLight<'a> {
    Spot(&'a CheckedLight, &'a Cone),
    Omni(&'a Omni),
    Directional(&'a Parallel),
}

/// Values of a light that are compiled into its lighting pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BakedStraight {
    Spot(BakedSpot),
    Omni(ShadowFilter, BakedFilter),
    Directional(ShadowFilter, BakedFilter),
}

/// Part of a scene that a light's shadow map shows.
#[derive(Clone, Debug)]
pub(crate) enum Fitted {
    Spot(FittedFaces),
    Omni(Box<FittedCube>),
    Directional(DirectionalMapFit),
}

/// Light in a scene: its uniform, and the projections of its map.
#[derive(Clone, Debug)]
pub(crate) enum Placed {
    Spot(GpuSpot),
    Omni(GpuOmni),
    Directional(GpuDirectional),
}

impl Placed {
    fn uniform(&self) -> &[u8] {
        match self {
            Self::Spot(spot) => bytemuck::bytes_of(&spot.uniform),
            Self::Omni(omni) => bytemuck::bytes_of(&omni.uniform),
            Self::Directional(directional) => bytemuck::bytes_of(&directional.uniform),
        }
    }

    pub fn views(&self) -> &MapViews {
        match self {
            Self::Spot(spot) => &spot.views,
            Self::Omni(omni) => &omni.views,
            Self::Directional(directional) => &directional.views,
        }
    }
}

pub(crate) struct ReadyStraight {
    pub group: BindGroup,
    pub drawn: bool,
}

impl<'a> StraightLight<'a> {
    /// Returns the straight light in `light`. `None` if its rays are bent.
    pub fn of(light: &'a CheckedLight) -> Option<Self> {
        match light.rays() {
            LightRays::Cone(cone) => Some(Self::Spot(light, cone)),
            LightRays::Omni(omni) => Some(Self::Omni(omni)),
            LightRays::Parallel(parallel) => Some(Self::Directional(parallel)),
            LightRays::Bent(_) => None,
        }
    }

    pub fn map_size(self, shadows: &ShadowSettings) -> MapSize {
        match self {
            Self::Spot(light, _) => spot::map_size(light.light(), shadows),
            Self::Omni(_) => omni::map_size(shadows),
            Self::Directional(_) => directional::map_size(shadows),
        }
    }

    pub fn baked(self, filter: ShadowFilter) -> BakedStraight {
        match self {
            Self::Spot(light, _) => BakedStraight::Spot(BakedSpot::of(light, filter)),
            Self::Omni(omni) => BakedStraight::Omni(filter, BakedFilter::of(&omni.light_profile)),
            Self::Directional(parallel) => {
                BakedStraight::Directional(filter, BakedFilter::of(&parallel.light_profile))
            }
        }
    }

    pub fn light_profile(self) -> &'a LightProfile {
        match self {
            Self::Spot(_, cone) => &cone.light_profile,
            Self::Omni(omni) => &omni.light_profile,
            Self::Directional(parallel) => &parallel.light_profile,
        }
    }

    /// Returns the world positions whose convex hull contains everything that the light can light in a scene.
    pub fn corners_in_world(self, posed: &PosedScene) -> Vec<DVec3> {
        match self {
            Self::Spot(_, cone) => spot::corners_in_world(cone, posed).to_vec(),
            Self::Omni(omni) => omni::corners_in_world(omni, posed),
            Self::Directional(parallel) => directional::corners_in_world(parallel, posed).to_vec(),
        }
    }

    /// Returns the world position of the source. `None` if light comes from outside every scene.
    pub fn source_in_world(self) -> Option<DVec3> {
        match self {
            Self::Spot(_, cone) => Some(cone.translation),
            Self::Omni(omni) => Some(omni.translation),
            Self::Directional(_) => None,
        }
    }

    /// Fits the light's shadow map to a scene. The fit is empty for a light without shadows.
    pub fn fit_map(self, scene: &GpuScene, shadows: &ShadowSettings) -> Fitted {
        let shadowed = self.light_profile().shadow_enable;
        match self {
            Self::Spot(light, cone) if shadowed => {
                Fitted::Spot(spot::fit_map((light.light(), cone), scene, shadows))
            }
            Self::Spot(..) => Fitted::Spot(FittedFaces::NONE),
            Self::Omni(omni) if shadowed => Fitted::Omni(Box::new(omni::fit_map(omni, scene, shadows))),
            Self::Omni(_) => Fitted::Omni(Box::new(FittedCube::none())),
            Self::Directional(parallel) if shadowed => {
                Fitted::Directional(directional::fit_map(parallel, scene, shadows))
            }
            Self::Directional(_) => Fitted::Directional(DirectionalMapFit::NONE),
        }
    }

    /// Makes the uniform and the projections of the light in a scene. `fitted` must be the fit of a light of the same
    /// shape.
    pub fn placed(self, fitted: &Fitted, scene: &GpuScene, shadows: &ShadowSettings) -> Placed {
        match (self, fitted) {
            (Self::Spot(_, cone), Fitted::Spot(fitted)) => {
                Placed::Spot(GpuSpot::new(cone, scene, shadows, fitted))
            }
            (Self::Omni(omni), Fitted::Omni(fitted)) => {
                Placed::Omni(GpuOmni::new(omni, scene, shadows, fitted))
            }
            (Self::Directional(parallel), Fitted::Directional(fitted)) => {
                Placed::Directional(GpuDirectional::new(parallel, scene, shadows, fitted))
            }
            _ => unreachable!("a light keeps its shape while its key stays the same"),
        }
    }
}

impl BakedStraight {
    #[cfg(test)]
    pub fn all() -> impl Iterator<Item = Self> {
        let filters = BakedFilter::samples().into_iter();
        let others = filters.zip(ShadowFilter::ALL.into_iter().cycle());
        let others = others.flat_map(|(light, map)| [Self::Omni(map, light), Self::Directional(map, light)]);
        BakedSpot::all().map(Self::Spot).chain(others)
    }

    /// Returns a label, and WGSL with the constants in it.
    pub fn wgsl(self) -> (&'static str, String) {
        match self {
            Self::Spot(baked) => ("spot", baked.into_wgsl(shaders::SPOT)),
            Self::Omni(map, light) => ("omni", light.into_wgsl(&with_filter(map, shaders::OMNI))),
            Self::Directional(map, light) => {
                ("directional", light.into_wgsl(&with_filter(map, shaders::DIRECTIONAL)))
            }
        }
    }
}

/// The pipelines of straight lights, shared by all scenes and lights.
#[derive(Debug)]
pub(crate) struct StraightPass {
    shadow: ShadowPass,
    lighting: PassVariants<BakedStraight>,
    /// Layouts of the view, the surface, the light and the links.
    group_layouts: [BindGroupLayout; 4],
    sampler: Sampler,
}

/// Cached shadow map of one straight light.
#[derive(Debug)]
pub(crate) struct StraightSlot {
    map: ShadowMap,
    /// Key of the cached map, and its fit. `None` before the first one is drawn.
    shown: Option<(MapKey, Fitted)>,
}

impl StraightSlot {
    pub fn invalidate(&mut self) {
        self.shown = None;
    }

    pub fn size(&self) -> MapSize {
        self.map.target.size
    }

    pub fn map_key(&self) -> Option<MapKey> {
        self.shown.as_ref().map(|(key, _)| *key)
    }
}

impl StraightPass {
    /// Compiles the pipelines. `camera_groups` are the layouts of the view and the surface.
    pub fn new(gpu: &Gpu, camera_groups: [&BindGroupLayout; 2], scene: &SceneGroupLayouts) -> Self {
        let ([view, surface], own) = (camera_groups, gpu.bind_group_layout("straight light", &BINDINGS));
        Self {
            shadow: ShadowPass::new(gpu, &scene.material),
            lighting: PassVariants::new(),
            group_layouts: [view.clone(), surface.clone(), own, scene.links.clone()],
            sampler: gpu
                .device
                .create_sampler(&wgpu::SamplerDescriptor { label: Some("shadow"), ..Default::default() }),
        }
    }

    /// Returns the lighting pass with the compiled-in values `baked`, for lights with links if `linked`.
    pub fn lighting(&self, gpu: &Gpu, baked: BakedStraight, linked: bool) -> Arc<LightingPass> {
        self.lighting.get(baked, linked, || {
            let (label, wgsl) = baked.wgsl();
            LightingPass::of_light(gpu, label, &wgsl, linked, self.group_layouts.each_ref())
        })
    }

    pub fn slot(&self, gpu: &Gpu, size: MapSize) -> StraightSlot {
        StraightSlot { map: self.shadow.new_map(gpu, size), shown: None }
    }

    /// Updates the shadow map in `slot` for `light`, with the casters that `linked` selects.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        slot: &mut StraightSlot,
        (key, light): (MapKey, StraightLight),
        (scene, linked, shadows): (&GpuScene, Option<&LinkedCasters>, &ShadowSettings),
    ) -> Result<ReadyStraight, RenderError> {
        let kept = slot.shown.take().filter(|(kept, _)| *kept == key);
        let drawn = kept.is_none() && light.light_profile().shadow_enable;
        let (_, fitted) = kept.unwrap_or_else(|| (key, light.fit_map(scene, shadows)));
        let placed = light.placed(&fitted, scene, shadows);
        let uniform = gpu.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("straight light"),
            contents: placed.uniform(),
            usage: BufferUsages::UNIFORM,
        });
        let resources = [
            uniform.as_entire_binding(),
            BindingResource::TextureView(&slot.map.target.all),
            BindingResource::Sampler(&self.sampler),
        ];
        // One per picture: lights that share a map have different colors.
        let group = gpu.bind_group("straight light", &self.group_layouts[2], &resources);
        if drawn {
            let casting = caster_set(gpu, scene, linked, shadows.mesh_error)?;
            let what = (scene, &casting);
            let source = light.source_in_world().map(|source| source - scene.posed.origin_in_world);
            let views = placed.views().shadow_views();
            let views = (&views[..], source, shadows.culling);
            let triangles = self.shadow.draw(gpu, encoder, &slot.map, views, what)?;
            gpu.end_stage(encoder, FrameStage::Draw)?;
            let MapSize { side, layers } = slot.map.target.size;
            gpu.stages.count(|counters| {
                counters.triangles_seen += triangles;
                counters.triangles_drawn += triangles;
                counters.texels += u64::from(layers) * u64::from(side).pow(2);
            });
        }
        slot.shown = Some((key, fitted));
        Ok(ReadyStraight { group, drawn })
    }
}

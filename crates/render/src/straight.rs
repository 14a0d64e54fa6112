//! Lights with straight rays, whose maps are drawn with ordinary matrices. `spot.rs`, `omni.rs` and `directional.rs`
//! place, fit and look up each shape.

use glam::DVec3;
use light::{CheckedLight, Cone, LightProfile, LightRays, Omni, Parallel};
use scene::PosedScene;
use wgpu::{BindGroup, BindGroupLayout, BindingType, BufferUsages, CommandEncoder};

use crate::baked_filter::BakedFilter;
use crate::directional::{self, DirectionalMapFit};
use crate::gpu_scene::{GpuScene, SceneGroupLayouts};
use crate::lighting::{LightConstants, LightPasses};
use crate::linked::CasterSource;
use crate::map_key::MapKey;
use crate::map_views::PlacedLight;
use crate::omni_faces::{self, FittedCube};
use crate::pipeline::{NON_FILTERING, RAW_TEXTURE_LAYERS, UNIFORM};
use crate::shadow::{ShadowMap, ShadowPass, ShadowViews};
use crate::shadow_settings::{MapSize, with_filter};
use crate::spot_faces::{self, FittedFaces};
use crate::stages::FrameStage;
use crate::{Gpu, RenderError, ShadowFilter, ShadowSettings, omni, shaders, spot};

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

/// Part of a scene that a light's shadow map shows.
#[derive(Clone, Debug)]
pub(crate) enum Fitted {
    Spot(FittedFaces),
    Omni(Box<FittedCube>),
    Directional(DirectionalMapFit),
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

    /// Returns the number of faces of the light's map.
    pub fn face_count(self) -> usize {
        match self {
            Self::Spot(light, _) => spot_faces::face_count(light.light()),
            Self::Omni(_) => omni_faces::FACES,
            Self::Directional(_) => 1,
        }
    }

    pub fn baked(self, filter: ShadowFilter) -> BakedStraight {
        let shape = match self {
            Self::Spot(..) => BakedShape::Spot { cube: self.face_count() > 1 },
            Self::Omni(_) => BakedShape::Omni,
            Self::Directional(_) => BakedShape::Directional,
        };
        BakedStraight { shape, filter, light_profile: BakedFilter::of(self.light_profile()) }
    }

    fn light_profile(self) -> &'a LightProfile {
        match self {
            Self::Spot(_, Cone { light_profile, .. })
            | Self::Omni(Omni { light_profile, .. })
            | Self::Directional(Parallel { light_profile, .. }) => light_profile,
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
            Self::Spot(light, cone) if shadowed => Fitted::Spot(spot::fit_map(light.light(), cone, scene, shadows)),
            Self::Spot(..) => Fitted::Spot(FittedFaces::NONE),
            Self::Omni(omni) if shadowed => Fitted::Omni(Box::new(omni::fit_map(omni, scene, shadows))),
            Self::Omni(_) => Fitted::Omni(Box::new(FittedCube::NONE)),
            Self::Directional(parallel) if shadowed => {
                Fitted::Directional(directional::fit_map(parallel, scene, shadows))
            }
            Self::Directional(_) => Fitted::Directional(DirectionalMapFit::NONE),
        }
    }

    /// Makes the uniform and the projections of the light in a scene. `fitted` must be the fit of a light of the same
    /// shape.
    pub fn placed(self, fitted: &Fitted, scene: &GpuScene, shadows: &ShadowSettings) -> PlacedLight {
        match (self, fitted) {
            (Self::Spot(_, cone), Fitted::Spot(fitted)) => spot::placed(cone, scene, shadows, fitted),
            (Self::Omni(omni), Fitted::Omni(fitted)) => omni::placed(omni, scene, shadows, fitted),
            (Self::Directional(parallel), Fitted::Directional(fitted)) => {
                directional::placed(parallel, scene, shadows, fitted)
            }
            _ => unreachable!("a light keeps its shape while its key stays the same"),
        }
    }
}

impl BakedStraight {
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
    shadow: ShadowPass,
    pub lighting: LightPasses<BakedStraight>,
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
        Self {
            shadow: ShadowPass::new(gpu, &scene.material),
            lighting: LightPasses::new(gpu, "straight light", &BINDINGS, camera_groups, &scene.links),
        }
    }

    pub fn slot(&self, gpu: &Gpu, size: MapSize) -> StraightSlot {
        StraightSlot { map: self.shadow.new_map(gpu, size), shown: None }
    }

    /// Updates the shadow map in `slot` for `light`. Returns group 2 of its lighting pass, and true if the map was
    /// drawn.
    pub fn prepare(
        &self,
        gpu: &Gpu,
        encoder: &mut CommandEncoder,
        slot: &mut StraightSlot,
        key: MapKey,
        light: StraightLight,
        source: CasterSource,
    ) -> Result<(BindGroup, bool), RenderError> {
        let CasterSource { scene, shadows, .. } = source;
        let kept = slot.shown.take().filter(|(kept, _)| *kept == key);
        let drawn = kept.is_none() && light.light_profile().shadow_enable;
        let (_, fitted) = kept.unwrap_or_else(|| (key, light.fit_map(scene, shadows)));
        let placed = light.placed(&fitted, scene, shadows);
        let uniform = gpu.buffer_with("straight light", placed.uniform.bytes(), BufferUsages::UNIFORM);
        // One per picture: lights that share a map have different colors.
        let group = self.lighting.light_group(gpu, &[&uniform], &slot.map.target);
        if drawn {
            let views = ShadowViews {
                faces: &placed.views.shadow_views(),
                source: light.source_in_world().map(|source| source - scene.posed.origin_in_world),
                culling: shadows.culling,
            };
            let triangles = self.shadow.draw(gpu, encoder, &slot.map, views, scene, &source.caster_set(gpu)?)?;
            gpu.end_stage(encoder, FrameStage::Draw)?;
            let MapSize { side, layers } = slot.map.target.size;
            gpu.stages.count(|counters| {
                counters.triangles_seen += triangles;
                counters.triangles_drawn += triangles;
                counters.texels += u64::from(layers) * u64::from(side).pow(2);
            });
        }
        slot.shown = Some((key, fitted));
        Ok((group, drawn))
    }
}

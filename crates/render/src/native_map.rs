//! Lights of the native backend, and its map painter.

use std::sync::Arc;

use light::LightPart;
use relight::{DepthMap, RelitBent, RelitDirectional, RelitLight, RelitOmni, RelitSpot};
use shadow::{MapSize, PlacedLight, StraightCoords};

use crate::backend::Backend;
use crate::bendy_light::NativeOnto;
use crate::map_painter::{MapBuilders, MapPainter, MapStorage, NativeMapBuilders};
use crate::map_source::MapSource;
use crate::{Gpu, RenderError, bendy_light, native_straight};

/// Light in the form that `relight` draws, with its shadow map if it casts shadows.
#[derive(Debug)]
pub(crate) struct NativeLight {
    pub light: RelitLight,
    pub map: Option<Arc<DepthMap>>,
}

/// Draws shadow maps of lights in a scene on the CPU.
pub(crate) struct NativeMaps<'a>(pub &'a Gpu);

impl MapPainter for NativeMaps<'_> {
    type Light = NativeLight;
    const BACKEND: Backend = Backend::Native;

    fn storage(&self, size: MapSize) -> MapStorage {
        MapStorage::Native(Arc::new(DepthMap::new(size.side as usize, size.layers as usize)))
    }

    fn draw(
        &mut self,
        storage: &mut MapStorage,
        placed: &PlacedLight,
        source: &MapSource,
        builders: MapBuilders,
    ) -> Result<(), RenderError> {
        let Self(gpu) = self;
        let MapStorage::Native(map) = storage else { unreachable!("the storage was made for the processor") };
        if Arc::get_mut(map).is_none() {
            // A layer that is being drawn still reads the map before.
            *map = Arc::new(DepthMap::new(map.side(), map.faces()));
        }
        let into = Arc::get_mut(map).expect("nothing else has it");
        let NativeMapBuilders { bent, straight } = builders.native;
        match placed {
            PlacedLight::Straight(placed) => native_straight::draw_map(gpu, straight, placed, source, into),
            PlacedLight::Bent(placed) => match &placed.shape {
                Some(shape) => bendy_light::draw_map(gpu, bent, placed, shape, source, NativeOnto::Map(into)),
                None => Ok(()),
            },
        }
    }

    fn light(&self, storage: &MapStorage, placed: PlacedLight) -> NativeLight {
        let is_shadowed = placed.light_profile().shadow_enable;
        let map = if let MapStorage::Native(map) = storage { is_shadowed.then(|| Arc::clone(map)) } else { None };
        NativeLight { light: relit_light(placed), map }
    }
}

/// Converts a light to the form that `relight` draws.
fn relit_light(placed: PlacedLight) -> RelitLight {
    let placed = match placed {
        PlacedLight::Bent(bent) => {
            let LightPart { tube, t_start, t_span, .. } = &bent.part;
            return RelitLight::Bent(Box::new(RelitBent::new(
                tube,
                bent.tube_from_scene,
                [*t_start, *t_span],
                bent.map,
            )));
        }
        PlacedLight::Straight(straight) => straight,
    };
    let (light_from_scene, profile) = (placed.light_from_scene.as_mat4(), placed.light_profile);
    match placed.coords {
        StraightCoords::Spot { tan_outer, range, map } => {
            RelitLight::Spot(Box::new(RelitSpot::new(light_from_scene, profile, tan_outer, range, map)))
        }
        StraightCoords::Omni { range, map } => {
            RelitLight::Omni(Box::new(RelitOmni::new(light_from_scene, profile, range, map)))
        }
        StraightCoords::Directional { window, map } => {
            RelitLight::Directional(Box::new(RelitDirectional::new(light_from_scene, profile, window, map)))
        }
    }
}

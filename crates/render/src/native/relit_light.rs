//! Lights in the form that `relight` draws.

use std::sync::Arc;

use light::LightPart;
use relight::{DepthMap, RelitBent, RelitDirectional, RelitLight, RelitOmni, RelitSpot};
use shadow::{PlacedLight, StraightCoords};

/// Light in the form that `relight` draws, with its shadow map if it casts shadows.
#[derive(Debug)]
pub(crate) struct NativeLight {
    pub light: RelitLight,
    pub map: Option<Arc<DepthMap>>,
}

/// Converts a light to the form that `relight` draws.
pub(crate) fn relit_light(placed: PlacedLight) -> RelitLight {
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

//! `KHR_lights_punctual`: its spotlights, placed in the world.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use gltf::json::extensions::scene::khr_lights_punctual::{Light as GltfLight, Type};
use gltf::json::validation::Checked;
use light::parameters::{COLOR, CONE_ANGLE, CONE_SOFTNESS, INTENSITY, NAME, RANGE};
use light::{CheckedLight, Light, Transform};

use super::nodes::{Place, rigid};
use super::{Source, name_or};
use crate::notes::Notes;

/// The widest half angle drawn, degrees: at 90 a cone is a plane.
const WIDEST_CONE_ANGLE: f64 = 89.9;

/// Every spotlight of the drawn scene, in node order. Others are left out, with a note.
pub fn read(source: &Source, places: &[Place], notes: &mut Notes) -> Vec<Arc<CheckedLight>> {
    let mut lights = Vec::new();
    for place in places {
        let Some(node) = place.node.map(|index| &source.root.nodes[index]) else { continue };
        let extension = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        let Some(light) = extension.and_then(|e| source.root.get(e.light)) else { continue };
        let name = name_or(node.name.as_deref().or(light.name.as_deref()), "light", lights.len());
        match light.type_ {
            Checked::Valid(Type::Point) => {
                notes.add("point lights are not drawn, only spotlights and BendyLights are", name);
            }
            Checked::Valid(Type::Directional) => {
                notes.add("directional lights are not drawn, only spotlights and BendyLights are", name);
            }
            Checked::Valid(Type::Spot) | Checked::Invalid => match spot(light, place, &name, notes) {
                Some(spot) => lights.push(Arc::new(spot)),
                None => notes.add("spotlights whose numbers make no light are left out", name),
            },
        }
    }
    lights
}

/// The spotlight in degrees and candela, or `None` where its numbers make none.
fn spot(light: &GltfLight, place: &Place, name: &str, notes: &mut Notes) -> Option<CheckedLight> {
    let cone = light.spot.as_ref()?;
    let (inner, outer) = (f64::from(cone.inner_cone_angle), f64::from(cone.outer_cone_angle));
    let range = light.range.map(f64::from).filter(|range| *range > 0.0 && range.is_finite());
    let world_from_light = rigid(&place.world_from_local);
    let color = DVec3::from_array(light.color.map(f64::from));
    let intensity = f64::from(light.intensity);
    let spot = Light::spot()
        .placed(Transform {
            translation: world_from_light.translation,
            rotation: DQuat::from_mat3(&world_from_light.matrix3),
            scale: 1.0,
        })
        .with(NAME, name.into())
        .with(COLOR, color)
        .with(INTENSITY, intensity)
        .with(CONE_ANGLE, outer.to_degrees().min(WIDEST_CONE_ANGLE))
        .with(CONE_SOFTNESS, 1.0 - (inner / outer).clamp(0.0, 1.0))
        .with(RANGE, range);
    let shines = intensity >= 0.0 && color.min_element() >= 0.0;
    let checked = CheckedLight::new(spot).ok().filter(|_| shines)?;
    if outer.to_degrees() > WIDEST_CONE_ANGLE {
        notes.add("cone angles of 90 degrees and more are narrowed", name);
    }
    if range.is_none() && light.range.is_some() {
        notes.add("ranges that are not more than 0 are ignored", name);
    }
    Some(checked)
}

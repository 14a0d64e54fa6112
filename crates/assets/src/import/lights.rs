//! Import of `KHR_lights_punctual`, with world transforms.

use std::sync::Arc;

use glam::{DQuat, DVec3};
use gltf::json::extensions::scene::khr_lights_punctual::{Light as GltfLight, Type};
use gltf::json::validation::Checked;
use light::parameters::{COLOR, CONE_ANGLE, CONE_SOFTNESS, INTENSITY, NAME, PROFILE, PROFILE_POWER, RANGE};
use light::{CheckedLight, Light, ProfileCurve, Transform};

use super::nodes::PlacedNode;
use super::placement::rigid;
use super::{ImportSource, display_name};
use crate::notes::Notes;

/// Largest half angle in degrees. At 90 degrees a cone is a plane.
const MAX_CONE_ANGLE_DEGREES: f64 = 89.9;
/// Default half angle of glTF in degrees.
const DEFAULT_CONE_ANGLE_DEGREES: f64 = 45.0;

/// Returns every light of the drawn scene, in node order. Invalid numbers are replaced, with a note.
pub fn read(source: &ImportSource, nodes: &[PlacedNode], notes: &mut Notes) -> Vec<Arc<CheckedLight>> {
    let mut lights = Vec::new();
    for placed in nodes {
        let Some(node) = placed.node.map(|index| &source.root.nodes[index]) else { continue };
        let extension = node.extensions.as_ref().and_then(|e| e.khr_lights_punctual.as_ref());
        let Some(light) = extension.and_then(|e| source.root.get(e.light)) else { continue };
        let name = display_name(node.name.as_deref().or(light.name.as_deref()), "light", lights.len());
        match CheckedLight::new(light_from_gltf(light, placed, &name, notes)) {
            Ok(light) => lights.push(Arc::new(light)),
            // All other numbers are valid by now.
            Err(_) => notes.add("lights that stand infinitely far away are left out", name),
        }
    }
    lights
}

/// Converts a light. Angles become degrees; intensities stay in candela or lux.
fn light_from_gltf(light: &GltfLight, placed: &PlacedNode, name: &str, notes: &mut Notes) -> Light {
    let world_from_light = rigid(&placed.world_from_local);
    let transform = Transform {
        translation: world_from_light.translation,
        rotation: DQuat::from_mat3(&world_from_light.matrix3),
        scale: 1.0,
    };
    let given = [light.color[0], light.color[1], light.color[2], light.intensity].map(f64::from);
    let [red, green, blue, intensity] = given.map(|x| if x.is_finite() { x.max(0.0) } else { 0.0 });
    if given != [red, green, blue, intensity] {
        notes.add("colors and intensities below 0 are taken as 0", name);
    }
    let range = light.range.map(f64::from).filter(|range| *range > 0.0 && range.is_finite());
    let read = match light.type_ {
        Checked::Valid(Type::Directional) => Light::directional(),
        Checked::Valid(Type::Point) => Light::omni(),
        Checked::Valid(Type::Spot) | Checked::Invalid => with_cone(light, name, notes),
    };
    if range.is_none() && light.range.is_some() && read.value(&RANGE).is_some() {
        notes.add("ranges that are not more than 0 are ignored", name);
    }
    read.with_transform(transform)
        .with(NAME, name.into())
        .with(COLOR, DVec3::new(red, green, blue))
        .with(INTENSITY, intensity)
        .with(RANGE, range)
}

/// Returns a spotlight with its cone and the penumbra that the extension recommends: the squared share of the
/// cosine between those of the outer and the inner angle.
fn with_cone(light: &GltfLight, name: &str, notes: &mut Notes) -> Light {
    let cone = light.spot.as_ref().map(|cone| [cone.inner_cone_angle, cone.outer_cone_angle].map(f64::from));
    let [inner, outer] = cone.unwrap_or_default();
    let angle = outer.to_degrees();
    let (cone_angle, softness) = if angle > 0.0 && angle.is_finite() {
        (angle.min(MAX_CONE_ANGLE_DEGREES), 1.0 - (inner / outer).clamp(0.0, 1.0))
    } else {
        notes.add("cone angles that are not more than 0 are taken as 45 degrees", name);
        (DEFAULT_CONE_ANGLE_DEGREES, 1.0)
    };
    if cone_angle < angle {
        notes.add("cone angles of 90 degrees and more are narrowed", name);
    }
    Light::spot()
        .with(CONE_ANGLE, cone_angle)
        .with(CONE_SOFTNESS, softness)
        .with(PROFILE, ProfileCurve::Power)
        .with(PROFILE_POWER, 2.0)
}

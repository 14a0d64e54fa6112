//! Default light for scenes without lights.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::parameters::{INTENSITY, NAME};
use light::{CheckedLight, Light, SceneBounds, Transform};
use scene::{Camera, DEFAULT_ASPECT, framing_camera};

use crate::LoadedScene;

const KEY_NAME: &str = "default key";
/// Intensity in lux. A white wall perpendicular to the light then has the radiance of full white.
const KEY_INTENSITY_LUX: f64 = PI;
/// Direction of the light in camera space: forwards, down and to the right. It turns so little sideways that it
/// still grazes the side faces that the framing camera sees from its corner.
const LIGHT_DIRECTION_IN_CAMERA: DVec3 = DVec3::new(0.2, -0.6, -1.0);

impl LoadedScene {
    /// Adds a key light if the scene has triangles and no light, with a note that names it.
    ///
    /// Callers that use the scene's own lights need it. Callers that bring other lights want neither the key
    /// nor the note.
    #[must_use]
    pub fn with_default_light(mut self) -> Self {
        let triangles = self.scene.meshes.iter().flat_map(|mesh| &mesh.primitives);
        if !self.contents.lights.is_empty() || triangles.map(|p| p.indices.len()).sum::<usize>() == 0 {
            return self;
        }
        let reach = SceneBounds::from(&self.scene);
        if let Some(key) = default_key(&reach, &self.contents.cameras) {
            self.contents.lights.push(Arc::new(key));
            self.notes.push(format!(
                "the scene has no lights of its own, so loading it adds one that can be removed: {KEY_NAME}"
            ));
        }
        self
    }
}

/// Returns a directional light from beside the first camera, or from beside the framing camera if there is none.
/// It stands on the sphere around the scene's box, so that its handles do not hide the scene.
fn default_key(reach: &SceneBounds, cameras: &[Camera]) -> Option<CheckedLight> {
    let camera = cameras.first().cloned().unwrap_or_else(|| framing_camera(reach, DEFAULT_ASPECT));
    let rotation =
        camera.rotation.normalize() * DQuat::from_rotation_arc(DVec3::NEG_Z, LIGHT_DIRECTION_IN_CAMERA.normalize());
    let translation = reach.center + rotation * DVec3::Z * reach.half_extent.length();
    let key = Light::directional()
        .with_transform(Transform { translation, rotation, scale: 1.0 })
        .with(NAME, KEY_NAME.into())
        .with(INTENSITY, KEY_INTENSITY_LUX);
    CheckedLight::new(key).ok()
}

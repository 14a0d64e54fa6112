//! A light for scenes that have none.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::parameters::{INTENSITY, NAME};
use light::{CheckedLight, Light, SceneBounds, Transform};
use scene::{Camera, DEFAULT_ASPECT, framing_camera};

use crate::LoadedScene;

/// What it is called.
const KEY_NAME: &str = "default key";
/// Lux: a white wall square to it is as bright as white can be.
const KEY_INTENSITY_LUX: f64 = PI;
/// Where its light goes, as the camera sees it: ahead, from above and from the left. So little from the side that it still
/// grazes the flank of what the framing camera sees from its corner.
const LIGHT_DIRECTION_IN_CAMERA: DVec3 = DVec3::new(0.2, -0.6, -1.0);

impl LoadedScene {
    /// The scene as it is first seen: under its own lights or, where it has triangles and no light, under a key that a note
    /// names.
    ///
    /// For whoever takes a scene's lights; whoever brings others wants neither the key nor the note.
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

/// A directional light from beside the first camera, or the one that a picture would be taken with. It stands off the
/// scene's box, where its handles are in nobody's way.
fn default_key(reach: &SceneBounds, cameras: &[Camera]) -> Option<CheckedLight> {
    let camera = cameras.first().cloned().unwrap_or_else(|| framing_camera(reach, DEFAULT_ASPECT));
    let rotation = camera.rotation.normalize()
        * DQuat::from_rotation_arc(DVec3::NEG_Z, LIGHT_DIRECTION_IN_CAMERA.normalize());
    let translation = reach.center + rotation * DVec3::Z * reach.half_extent.length();
    let key = Light::directional()
        .with_transform(Transform { translation, rotation, scale: 1.0 })
        .with(NAME, KEY_NAME.into())
        .with(INTENSITY, KEY_INTENSITY_LUX);
    CheckedLight::new(key).ok()
}

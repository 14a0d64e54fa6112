//! Scene to draw, under a bent light and under the same light before it was bent.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::parameters::{INTENSITY, ROTATION, TRANSLATION};
use light::{CheckedLight, Light, LightError, LightId, LightInstance};
use scene::{Camera, PosedScene, Scene, View};

use crate::bent::bent_and_spot;

/// Scene, view and lights of the benchmark.
#[derive(Clone, Debug)]
pub struct FrameSubject {
    /// Name in the report.
    pub name: String,
    pub(super) posed: Arc<PosedScene>,
    pub(super) view: View,
    /// The BendyLight that is edited.
    pub(super) bent: Light,
    /// A spotlight at the same position in the same direction.
    pub(super) spot: Light,
}

/// View and lights of a picture.
#[derive(Clone, Debug)]
pub(super) struct FrameRequest {
    pub view: View,
    pub lights: Vec<LightInstance>,
}

impl FrameSubject {
    /// Makes a subject of `scene` seen by `camera` in `size` pixels, under `light` alone. A straight light is bent into
    /// three segments. A bent one is straightened for the spotlight.
    pub fn new(name: &str, scene: Scene, camera: Camera, light: &Light, size: [u32; 2]) -> Result<Self, LightError> {
        let posed = scene::pose(scene, 0.0);
        let (bent, spot) = bent_and_spot(light, posed.bounds())?;
        Ok(Self { name: name.into(), posed, view: View::beauty(camera, size), bent, spot })
    }

    /// Returns the frame under `light` alone.
    pub(super) fn under(&self, light: Light) -> Result<FrameRequest, LightError> {
        Ok(FrameRequest { view: self.view.clone(), lights: vec![instance(0, light)?] })
    }

    /// Returns the distance by which lights and cameras move: a hundredth of half the scene's diagonal.
    pub(super) fn step(&self) -> f64 {
        0.01 * self.posed.half_extent.length()
    }
}

/// Makes `count` lights like `light`, rotated about the vertical axis through `middle`, together as bright as one.
pub(super) fn crowd(light: &Light, count: usize, middle: DVec3) -> Vec<Light> {
    let golden_angle = PI * (3.0 - 5_f64.sqrt());
    let turned = |index: usize| {
        let turn = DQuat::from_rotation_y(index as f64 * golden_angle);
        light
            .clone()
            .with(TRANSLATION, middle + turn * (light.get(TRANSLATION) - middle))
            .with(ROTATION, (turn * light.get(ROTATION)).normalize())
            .with(INTENSITY, light.get(INTENSITY) / count as f64)
    };
    (0..count).map(turned).collect()
}

/// Checks a light for a renderer.
pub(super) fn instance(id: u64, light: Light) -> Result<LightInstance, LightError> {
    Ok(LightInstance { id: LightId(id), light: Arc::new(CheckedLight::new(light)?) })
}

/// Moves `light` to step `k` of a circle around its position. No step is at the center.
pub(super) fn moved(light: &Light, k: usize, radius: f64) -> Light {
    let (sin, cos) = (0.2 * k as f64).sin_cos();
    light.clone().with(TRANSLATION, light.get(TRANSLATION) + radius * DVec3::new(sin, 0.0, cos))
}

//! What is drawn: a scene under a light that is bent, and the same light before that.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::parameters::{INTENSITY, ROTATION, TRANSLATION};
use light::{CheckedLight, Light, LightError, LightId, LightInstance};
use scene::{Camera, PosedScene, Scene, View};

use crate::bent::bent_and_spot;

/// What is drawn.
#[derive(Clone, Debug)]
pub struct FrameSubject {
    /// Names it in the report.
    pub name: String,
    pub(super) posed: Arc<PosedScene>,
    pub(super) view: View,
    /// The BendyLight that edits are made to.
    pub(super) bent: Light,
    /// A spotlight from the same place in the same direction.
    pub(super) spot: Light,
}

/// A picture that is asked for.
#[derive(Clone, Debug)]
pub(super) struct FrameRequest {
    pub view: View,
    pub lights: Vec<LightInstance>,
}

impl FrameSubject {
    /// `scene` as `camera` sees it in `size` pixels, under `light` alone. A straight light is bent into three segments;
    /// one that is bent is straightened, to have both.
    pub fn new(
        name: &str,
        scene: Scene,
        camera: Camera,
        light: &Light,
        size: [u32; 2],
    ) -> Result<Self, LightError> {
        let posed = scene::pose(scene);
        let (bent, spot) = bent_and_spot(light, posed.bounds())?;
        Ok(Self { name: name.into(), posed, view: View::beauty(camera, size), bent, spot })
    }

    /// A light that is drawn alone.
    pub(super) fn under(&self, light: Light) -> Result<FrameRequest, LightError> {
        Ok(FrameRequest { view: self.view.clone(), lights: vec![instance(0, light)?] })
    }

    /// What lights and cameras are moved by: a hundredth of how far the scene reaches.
    pub(super) fn step(&self) -> f64 {
        0.01 * self.posed.half_extent.length()
    }
}

/// `count` lights like `light`, turned about the vertical through `middle`, together as bright as one.
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

/// A light as pictures take it.
pub(super) fn instance(id: u64, light: Light) -> Result<LightInstance, LightError> {
    Ok(LightInstance { id: LightId(id), light: Arc::new(CheckedLight::new(light)?) })
}

/// `light` on its way around where it stands: step `k` of a circle, nowhere at its middle.
pub(super) fn moved(light: &Light, k: usize, radius: f64) -> Light {
    let (sin, cos) = (0.2 * k as f64).sin_cos();
    light.clone().with(TRANSLATION, light.get(TRANSLATION) + radius * DVec3::new(sin, 0.0, cos))
}

//! What is drawn: a scene under a light that is bent, and the same light before that.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DQuat, DVec3};
use light::parameters::{INTENSITY, RANGE, ROTATION, TRANSLATION};
use light::{CheckedLight, Light, LightError, LightId, LightInstance, Owner, bend_to, straighten, with_cone};
use scene::{Camera, PosedScene, Scene, View};

/// Segments of the bent light, where the scene brings none: those of the design's frame.
const SEGMENTS: usize = 3;
/// Half angle in degrees of the cone that is bent of a light without one.
const CONE_ANGLE: f64 = 30.0;
/// How far the middle of a straight light is moved aside, as a share of its length; the first that does not fold is
/// taken.
const ASIDE: [f64; 4] = [0.25, 0.12, 0.06, 0.03];

/// What is drawn.
#[derive(Clone, Debug)]
pub struct Subject {
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
pub(super) struct Frame {
    pub view: View,
    pub lights: Vec<LightInstance>,
}

impl Subject {
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
        let reach = posed.reach();
        let length = light.get(TRANSLATION).distance(reach.middle).max(0.5 * reach.half_extent.length());
        let (bent, spot) = if light.owner() == Owner::Bendy {
            (light.clone(), straighten(light)?)
        } else {
            let spot = with_cone(light, CONE_ANGLE, Some(reach.middle), length);
            (bent(&spot, SEGMENTS, length)?, spot)
        };
        Ok(Self { name: name.into(), posed, view: View::beauty(camera, size), bent, spot })
    }

    /// A light that is drawn alone.
    pub(super) fn under(&self, light: Light) -> Result<Frame, LightError> {
        Ok(Frame { view: self.view.clone(), lights: vec![instance(0, light)?] })
    }

    /// What lights and cameras are moved by: a hundredth of how far the scene reaches.
    pub(super) fn step(&self) -> f64 {
        0.01 * self.posed.half_extent.length()
    }
}

/// The spotlight `spot` without its range, of so many segments over `length` world units, bowed aside as evenly as they
/// can.
pub(super) fn bent(spot: &Light, segments: usize, length: f64) -> Result<Light, LightError> {
    let straight = bend_to(&spot.clone().with(RANGE, None), segments, length)?;
    let end = straight.points().last().map_or(1.0, |point| point.position.z);
    let bowed = |aside: f64| {
        straight.clone().with_points(|_, point| {
            let share = point.position.z / end;
            point.position.x = aside * end.abs() * 4.0 * share * (1.0 - share);
        })
    };
    let mut refused = None;
    for light in ASIDE.map(bowed) {
        match CheckedLight::new(light.clone()) {
            Ok(_) => return Ok(light),
            Err(why) => refused = Some(why),
        }
    }
    refused.map_or(Ok(straight), Err)
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

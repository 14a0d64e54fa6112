//! Pictures of all legal but extreme input have finite numbers only.

use glam::{DVec3, Vec4};
use light::parameters::{CONE_ANGLE, INTENSITY, WIDTH};
use light::{Light, LightInstance, LightRays, Transform};
use proptest::prelude::*;
use reference::Reference;
use render::{Aov, Picture, ShadowSettings, View};
use scene::{Material, Scene};
use serde::Serialize;

use super::adapter::{Adapter, StressPicture};
use super::light::{LightLimits, unit_cube};
use super::runner::{Check, CheckTally};
use super::scenes::{Shot, obstacle, shots, square};

/// Case with a shot, lights of the other shapes, a material, and an allowed error of simplified casters.
#[derive(Clone, Debug, Serialize)]
pub struct FiniteCase {
    #[serde(flatten)]
    pub shot: Shot,
    /// Intensity of all lights.
    pub intensity: f64,
    /// Position and direction of the other lights, light-local, and the spotlight's half angle in degrees, which is
    /// also the width of the directional light's window.
    pub spot: ([f64; 3], [f64; 3], f64),
    pub roughness: f32,
    pub metallic: f32,
    /// Scale of the scene along each axis; 0 flattens it.
    pub squash: [f64; 3],
    /// Allowed distance of simplified casters from the surface, in world units.
    pub mesh_error: f64,
}

/// Generates cases with lights up to the fold, with pinches, with facets without area, and sometimes with a flattened
/// scene.
pub fn cases() -> impl Strategy<Value = FiniteCase> {
    let any_light = LightLimits { segments: 4, fold: 1.0, pinched: true, flipping: true };
    let shot = shots(any_light, square(0.5..60.0), prop::collection::vec(obstacle(true), 0..6));
    let intensity = prop_oneof![Just(1.0), Just(1e300), Just(-1e300), Just(0.0), Just(1e-300)];
    let part = || prop_oneof![Just(0.0_f32).boxed(), Just(1.0_f32).boxed(), (0.0..1.0_f32).boxed()];
    let squash = prop_oneof![
        6 => Just([1.0; 3]), 1 => Just([1.0, 0.0, 1.0]), 1 => Just([0.0; 3]), 1 => Just([-1.0, 1.0, 1e-30])
    ];
    let spot = (unit_cube(), unit_cube(), prop_oneof![Just(25.0), Just(89.9), Just(0.01)])
        .prop_map(|(place, towards, angle)| (place.to_array(), towards.to_array(), angle));
    let mesh_error = prop_oneof![3 => Just(0.0), 1 => Just(1e-3), 1 => Just(0.3), 1 => Just(1e300)];
    (shot, intensity, spot, part(), part(), squash, mesh_error).prop_map(
        |(shot, intensity, spot, roughness, metallic, squash, mesh_error)| FiniteCase {
            shot,
            intensity,
            spot,
            roughness,
            metallic,
            squash,
            mesh_error,
        },
    )
}

impl FiniteCase {
    fn lights(&self) -> Vec<LightInstance> {
        let bendy = self.shot.light.clone().map_points(|_, point| point.intensity = self.intensity);
        let (place, towards, cone_angle) = self.spot;
        let transform = bendy.transform();
        let towards = DVec3::from(towards).try_normalize().unwrap_or(DVec3::NEG_Y);
        let there = Transform {
            translation: transform.world_from_local(place.into()),
            rotation: glam::DQuat::from_rotation_arc(DVec3::NEG_Z, towards),
            ..transform
        };
        let others = [
            Light::spot().with(CONE_ANGLE, cone_angle),
            Light::directional().with(WIDTH, Some(cone_angle)),
            Light::omni(),
        ];
        let others = others.map(|light| light.with_transform(there).with(INTENSITY, self.intensity));
        LightInstance::numbered(std::iter::once(bendy).chain(others)).expect("cases are valid")
    }
}

const OF_THE_CAMERA: [Aov; 3] = [Aov::Beauty, Aov::Depth, Aov::Normal];
const OF_A_LIGHT: [Aov; 4] = [Aov::T, Aov::Vw, Aov::Direction, Aov::Visibility];
/// AOVs that are checked for the two backends only, because the reference has no shadow maps.
const OF_A_MAP: [Aov; 1] = [Aov::Wireframe];

/// Checks every AOV of the camera and of all lights, and the displayed picture, by both backends and by the reference.
pub fn check(case: &FiniteCase, adapter: &Adapter, tally: &mut CheckTally) -> Check {
    let material = Material {
        roughness: case.roughness,
        metallic: case.metallic,
        base_color: Vec4::ONE,
        double_sided: true,
        ..Material::default()
    };
    let mut scene = case.shot.scene(&case.shot.facets, vec![material]);
    scene.nodes[0].parent_from_local *= glam::DAffine3::from_scale(case.squash.into());
    let (lights, mut view) = (case.lights(), case.shot.view());
    let mesh_error = case.mesh_error;
    let shadows = ShadowSettings { resolution: 512, mesh_error, straighten: false, ..ShadowSettings::default() };
    let shown = StressPicture { scene: &scene, view: &view, lights: &lights, shadows };
    let mut background = Vec::new();
    adapter.check_pictures(shown, OF_THE_CAMERA, |mut pictures| {
        if tally.is_planted {
            pictures[0].pixels[0][1] = f32::NAN;
        }
        background = pictures[0].pixels.iter().map(|pixel| pixel[3] == 0.0).collect();
        check_ranges(&OF_THE_CAMERA, &pictures, tally)
    })?;
    adapter.check_display(shown, |pixels| {
        let is_sound =
            |(pixel, is_background): (&[u8; 4], &bool)| pixel[3] == 255 && (!is_background || *pixel == [0, 0, 0, 255]);
        let are_sound = pixels.len() == background.len() && pixels.iter().zip(&background).all(is_sound);
        tally.holds(are_sound, || "a pixel on a screen is not opaque, or not black where nothing is".into())
    })?;
    for light in 0..lights.len() {
        view.light = light;
        let shown = StressPicture { scene: &scene, view: &view, lights: &lights, shadows };
        let has_curve = matches!(lights[light].light.rays(), LightRays::Bent(_) | LightRays::Cone(_));
        adapter.check_pictures(shown, OF_A_LIGHT, |pictures| {
            check_ranges(&OF_A_LIGHT, &pictures, tally)?;
            let [_, places, ..] = &pictures;
            let is_round = places.pixels.iter().all(|pixel| pixel[0].hypot(pixel[1]) < 1.0 + 1e-5);
            tally.holds(is_round || !has_curve, || format!("a place in light {light} is not in a circle"))
        })?;
        if has_curve {
            adapter.check_pictures(shown, OF_A_MAP, |pictures| check_ranges(&OF_A_MAP, &pictures, tally))?;
        }
    }
    by_the_reference(&scene, &view, &lights, tally)
}

/// Checks a small picture that the reference renders, with the last light.
fn by_the_reference(scene: &Scene, view: &View, lights: &[LightInstance], tally: &mut CheckTally) -> Check {
    let reference = Reference::new(scene::pose(scene.clone(), 0.0));
    for aov in OF_THE_CAMERA.into_iter().chain(OF_A_LIGHT) {
        let view = View { width: 24, height: 16, aov, ..view.clone() };
        let frame = reference.render(&view, lights, || ()).map_err(|error| error.to_string())?;
        frame.pixels.iter().try_for_each(|&pixel| check_range("reference", aov, pixel, tally))?;
    }
    Ok(())
}

fn check_ranges(aovs: &[Aov], pictures: &[Picture], tally: &mut CheckTally) -> Check {
    let pixels = aovs.iter().zip(pictures).flat_map(|(&aov, picture)| picture.pixels.iter().map(move |p| (aov, p)));
    pixels.into_iter().try_for_each(|(aov, pixel)| check_range("adapter", aov, pixel.map(f64::from), tally))
}

/// Checks that a pixel has finite numbers, each in the range of its AOV.
fn check_range(whose: &str, aov: Aov, pixel: [f64; 4], tally: &mut CheckTally) -> Check {
    let [x, y, z, alpha] = pixel;
    let length = DVec3::new(x, y, z).length();
    let in_range = match aov {
        _ if alpha == 0.0 => true,
        Aov::Visibility => (0.0..=1.0).contains(&x),
        // A few roundings of f32 each.
        Aov::Direction => (length - 1.0).abs() < 1e-6,
        // A square; the caller checks the circle for lights with a round cross-section.
        Aov::Vw => x.abs().max(y.abs()) < 1.0 + 1e-5,
        Aov::Beauty | Aov::Depth => x.min(y).min(z) >= 0.0,
        Aov::Wireframe => (0.0..=1.0).contains(&y),
        Aov::T | Aov::Normal | Aov::Position => true,
    };
    let sound = pixel.iter().all(|x| x.is_finite()) && (alpha == 0.0 || alpha == 1.0) && in_range;
    tally.holds(sound, || format!("a pixel of the {whose}'s {} is {pixel:?}", aov.name()))
}

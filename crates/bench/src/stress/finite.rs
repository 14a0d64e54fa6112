//! Pictures of everything that is legal and unkind hold numbers.

use bendy::{SpotLight, Transform};
use glam::{DVec3, Vec4};
use proptest::prelude::*;
use render::{Aov, Picture, ShadowSettings};
use scene::{Light, LightKind, Material};
use serde::Serialize;

use super::adapter::Adapter;
use super::light::{Lights, unit_cube};
use super::runner::{Check, Tally};
use super::scenes::{Shot, obstacle, shots, square};

/// A shot, a spotlight beside its light, and a material.
#[derive(Clone, Debug, Serialize)]
pub struct Case {
    #[serde(flatten)]
    pub shot: Shot,
    /// Of both lights.
    pub intensity: f64,
    /// Light-local place and direction of a spotlight, and its half angle in degrees.
    pub spot: ([f64; 3], [f64; 3], f64),
    pub roughness: f32,
    pub metallic: f32,
    /// The scene's own scale along each axis; 0 flattens it.
    pub squash: [f64; 3],
}

/// Lights up to the fold, with pinches; facets without area; everything flattened now and then.
pub fn cases() -> impl Strategy<Value = Case> {
    let any_light = Lights { segments: 4, fold: 1.0, pinched: true, flipping: true };
    let shot = shots(any_light, square(0.5..60.0), prop::collection::vec(obstacle(true), 0..6));
    let intensity = prop_oneof![Just(1.0), Just(1e300), Just(-1e300), Just(0.0), Just(1e-300)];
    let part = || prop_oneof![Just(0.0_f32).boxed(), Just(1.0_f32).boxed(), (0.0..1.0_f32).boxed()];
    let squash = prop_oneof![
        6 => Just([1.0; 3]), 1 => Just([1.0, 0.0, 1.0]), 1 => Just([0.0; 3]), 1 => Just([-1.0, 1.0, 1e-30])
    ];
    let spot = (unit_cube(), unit_cube(), prop_oneof![Just(25.0), Just(89.9), Just(0.01)])
        .prop_map(|(place, towards, angle)| (place.to_array(), towards.to_array(), angle));
    (shot, intensity, spot, part(), part(), squash).prop_map(
        |(shot, intensity, spot, roughness, metallic, squash)| Case {
            shot,
            intensity,
            spot,
            roughness,
            metallic,
            squash,
        },
    )
}

impl Case {
    fn lights(&self) -> [Light; 2] {
        let mut bendy = self.shot.light.clone();
        bendy.intensities.iter_mut().for_each(|intensity| *intensity = self.intensity);
        let (place, towards, cone_angle) = self.spot;
        let transform = bendy.transform;
        let towards = DVec3::from(towards).try_normalize().unwrap_or(DVec3::NEG_Y);
        let spot = SpotLight {
            transform: Transform {
                translation: transform.world_from_local(place.into()),
                rotation: glam::DQuat::from_rotation_arc(DVec3::NEG_Z, towards),
                ..transform
            },
            intensity: self.intensity,
            cone_angle,
            ..SpotLight::default()
        };
        [LightKind::Bendy(bendy), LightKind::Spot(spot)].map(|kind| Light { name: String::new(), kind })
    }
}

const OF_A_LIGHT: [Aov; 4] = [Aov::T, Aov::Vw, Aov::Direction, Aov::Visibility];

/// Holds for every AOV of the camera and of both lights.
pub fn check(case: &Case, adapter: &Adapter, tally: &mut Tally) -> Check {
    let material = Material {
        roughness: case.roughness,
        metallic: case.metallic,
        base_color: Vec4::ONE,
        double_sided: true,
        ..Material::default()
    };
    let mut scene = case.shot.scene(&case.shot.facets, vec![material]);
    let squashed = glam::DAffine3::from_scale(case.squash.into());
    scene.nodes[0].parent_from_local *= squashed;
    let (lights, mut view) = (case.lights(), case.shot.view());
    let shadows = ShadowSettings { resolution: 512, ..ShadowSettings::default() };
    let aovs = [Aov::Beauty, Aov::Depth, Aov::Normal];
    let mut pictures = adapter.pictures(&scene, &view, &lights, shadows, aovs)?.to_vec();
    if tally.planted {
        pictures[0].pixels[0][1] = f32::NAN;
    }
    sound(&aovs, &pictures, tally)?;
    for light in 0..lights.len() {
        view.light = light;
        sound(&OF_A_LIGHT, &adapter.pictures(&scene, &view, &lights, shadows, OF_A_LIGHT)?, tally)?;
    }
    Ok(())
}

fn sound(aovs: &[Aov], pictures: &[Picture], tally: &mut Tally) -> Check {
    for (aov, picture) in aovs.iter().zip(pictures) {
        for (index, pixel) in picture.pixels.iter().enumerate() {
            let place = || format!("pixel {index} of the {} is {pixel:?}", aov.name());
            tally.holds(pixel.iter().all(|x| x.is_finite()), place)?;
            tally.holds(pixel[3] == 0.0 || pixel[3] == 1.0, place)?;
            if pixel[3] == 0.0 {
                continue;
            }
            let length = glam::Vec3::new(pixel[0], pixel[1], pixel[2]).length();
            match aov {
                Aov::Visibility => tally.holds((0.0..=1.0).contains(&pixel[0]), place)?,
                // A few roundings of f32 each.
                Aov::Direction => tally.within(&place(), (f64::from(length) - 1.0).abs(), 1e-6)?,
                Aov::Beauty | Aov::Depth => tally.holds(pixel[0] >= 0.0, place)?,
                Aov::Vw => tally.within(&place(), f64::from(pixel[0].hypot(pixel[1])), 1.0 + 1e-5)?,
                Aov::T | Aov::Normal => (),
            }
        }
    }
    Ok(())
}

//! Tests that the comparison passes correct pictures and detects wrong ones.

use std::sync::{LazyLock, Mutex, OnceLock, PoisonError};

use glam::DVec3;
use light::Light;
use light::parameters::TRANSLATION;
use render::{Backend, Device, Host, Renderer, ShadowSettings};

use super::{Comparison, ComparisonSubject, ExpectedPicture, PixelVerdict, RenderedSubject};
use crate::shadow::scenes;

/// A still life under a bent light.
static SUBJECT: LazyLock<ComparisonSubject> = LazyLock::new(|| scenes::subjects(160, 90).swap_remove(1));
static EXPECTED: LazyLock<ExpectedPicture> = LazyLock::new(|| ExpectedPicture::new(&SUBJECT, || {}).expect("valid"));

const BACKENDS: [Backend; 2] = [Backend::Wgpu, Backend::Native];

fn drawn(subject: &ComparisonSubject) -> RenderedSubject {
    drawn_by(BACKENDS[0], subject)
}

fn drawn_by(backend: Backend, subject: &ComparisonSubject) -> RenderedSubject {
    static SHARED: [OnceLock<Mutex<Renderer>>; 2] = [const { OnceLock::new() }; 2];
    let open = || Device::open(Host::default(), Some(backend)).expect("tests need a graphics driver");
    let shared = || Mutex::new(Renderer::new(&open()).expect("the device works"));
    let mut renderer = SHARED[backend as usize].get_or_init(shared).lock().unwrap_or_else(PoisonError::into_inner);
    renderer.set_scene(&scene::pose(subject.scene.clone(), 0.0)).expect("fits");
    RenderedSubject::new(&mut renderer, subject, ShadowSettings::default()).expect("drawn")
}

fn json(found: &Comparison) -> String {
    serde_json::to_string(found).expect("plain data")
}

/// Bounds of the accuracy tests over real scenes.
fn passes(found: &Comparison) -> bool {
    found.not_finite == 0
        && found.missed + found.false_shadow + found.off_edge == 0
        && found.silhouettes + found.rim <= found.pixels / 1000
        && found.radiance_rmse <= 1e-3
        && found.displacement_texels.p99 <= 1.5
}

#[test]
fn a_right_picture_passes() {
    for backend in BACKENDS {
        let found = EXPECTED.compare(&drawn_by(backend, &SUBJECT));
        assert!(passes(&found), "{backend:?}: {}", json(&found));
        assert!(found.in_light > 1500 && found.displacement_pixels.count > 100, "{}", json(&found));
        // An edge is known to a sixth of a pixel if a texel is much smaller.
        assert!(found.displacement_pixels.p99 <= 0.5, "{backend:?}: {}", json(&found));
        assert!(found.verdicts.contains(&PixelVerdict::Boundary) && found.coincident == 0, "{}", json(&found));
    }
}

#[test]
fn a_displaced_shadow_is_detected() {
    let mut shifted = drawn(&SUBJECT);
    for picture in [&mut shifted.beauty, &mut shifted.visibility, &mut shifted.fine_visibility] {
        let pixels = if picture.width == SUBJECT.view.width { 1 } else { 3 };
        picture.pixels.rotate_right(pixels);
    }
    let found = EXPECTED.compare(&shifted);
    assert!(!passes(&found) && found.missed > 20 && found.false_shadow > 20, "{}", json(&found));
    // Rows are displaced by a pixel, columns by less.
    let displaced = found.displacement_pixels;
    assert!(displaced.max >= 0.8 && displaced.p50 >= 0.2, "{displaced:?}");
}

#[test]
fn a_displaced_light_is_detected() {
    let mut moved = SUBJECT.clone();
    let translation = moved.light.get(TRANSLATION) + DVec3::new(0.02, 0.0, 0.0);
    moved.light.set(TRANSLATION.to(translation));
    for backend in BACKENDS {
        let found = EXPECTED.compare(&drawn_by(backend, &moved));
        assert!(!passes(&found) && found.radiance_rmse > 1e-2, "{backend:?}: {}", json(&found));
    }
}

#[test]
fn a_displaced_object_is_detected() {
    let mut moved = SUBJECT.clone();
    moved.scene.nodes[1].parent_from_local.translation.x += 0.02;
    let found = EXPECTED.compare(&drawn(&moved));
    assert!(!passes(&found) && found.silhouettes > found.pixels / 500, "{}", json(&found));
}

/// Returns a light of `scenes` times the length of the scene. It is bent, comes down on the middle of the scene, and
/// its tube is 4 units wide.
fn long_light(scenes: f64) -> Light {
    // The floor is 12 units wide.
    let along = DVec3::new(0.5, -0.8, -0.3).normalize() * 12.0 * scenes;
    let aside = along.any_orthogonal_vector() * 0.2;
    // P(1/2) = (b0 + 2 b1 + b2) / 4 = 0.
    let [b0, b1, b2] = [aside - along / 2.0, -aside, aside + along / 2.0];
    let mut light = Light::bendy(vec![DVec3::ZERO, b1 - b0, b2 - b0], vec![2.0; 3]);
    light.set(TRANSLATION.to(DVec3::new(0.9, 0.5, 0.1) + b0));
    light.map_points(|_, point| point.intensity = 3.0)
}

/// A scene that is a small part of its light is drawn as accurately as one of the light's size.
#[test]
fn a_light_far_longer_than_the_scene_is_right() {
    for scenes in [100.0, 1e4, 1e6] {
        let subject = ComparisonSubject { light: long_light(scenes), ..SUBJECT.clone() };
        let expected = ExpectedPicture::new(&subject, || {}).expect("valid");
        for backend in BACKENDS {
            let found = expected.compare(&drawn_by(backend, &subject));
            println!("{scenes:e} scenes long, {backend:?}: {}", json(&found));
            assert!(passes(&found), "{scenes:e}, {backend:?}: {}", json(&found));
            assert!(found.in_light > 1500 && found.displacement_pixels.count > 100, "{}", json(&found));
        }
    }
}

#[test]
fn a_nan_is_detected() {
    let mut broken = drawn(&SUBJECT);
    broken.beauty.pixels[5000][1] = f32::NAN;
    let found = EXPECTED.compare(&broken);
    assert!(!passes(&found) && found.not_finite == 1, "{}", json(&found));
    assert_eq!(found.verdicts[5000], PixelVerdict::NotFinite);
}

#[test]
fn a_wrong_exposure_is_detected() {
    let mut bright = drawn(&SUBJECT);
    bright.beauty.pixels.iter_mut().flatten().for_each(|x| *x *= 1.002);
    let found = EXPECTED.compare(&bright);
    // An error of 0.2 % everywhere is a relative error of 2e-3 in every scene.
    assert!(!passes(&found) && (found.radiance_rmse - 2e-3).abs() < 5e-4, "{}", json(&found));
}

#[test]
fn a_leak_is_detected_in_pixels() {
    let mut leaking = drawn(&SUBJECT);
    // The middle of the largest shadow: the pixel with the largest dark surroundings.
    let is_dark = |pixel: usize| leaking.visibility.pixels[pixel] == [0.0, 0.0, 0.0, 1.0];
    let amid = |pixel: &usize| (0..7).all(|y| (0..7).all(|x| is_dark(pixel + y * 160 + x)));
    let corner = (0..160 * 80).find(amid).expect("a shadow is seven pixels wide");
    let pixel = corner + 3 * 160 + 3;
    // A fifth of the light is far less than a lit pixel has, and visible.
    leaking.visibility.pixels[pixel] = [0.2, 0.2, 0.2, 1.0];
    let found = EXPECTED.compare(&leaking);
    assert_eq!((found.off_edge_pixels.as_slice(), passes(&found)), ([pixel].as_slice(), false), "{}", json(&found));
}

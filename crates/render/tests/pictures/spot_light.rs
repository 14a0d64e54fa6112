//! Compares a spotlight without occluders with the formulas in f64.

use std::f64::consts::PI;

use glam::{DVec3, Vec4};
use light::parameters::{CONE_ANGLE, CONE_SOFTNESS, DECAY, INTENSITY, RANGE};
use light::{Decay, Light, Transform};
use render::{Aov, Picture, View};
use scene::{Material, Scene};

use crate::support::{floor, on_plane, picture, scene_of, spot, view};

/// Returns the floor y = 0 of one material.
fn plane(base_color: f32, metallic: f32, roughness: f32) -> Scene {
    let base_color = Vec4::new(base_color, base_color, base_color, 1.0);
    scene_of([floor(20.0, 0.0)], vec![Material { base_color, metallic, roughness, ..Material::default() }])
}

/// Returns an oblique spotlight, so that nothing is symmetric.
fn key() -> Light {
    spot(DVec3::new(1.0, 3.0, 0.5), DVec3::new(0.2, 0.0, -0.3))
}

fn camera(aov: Aov) -> View {
    view(DVec3::new(-2.0, 4.0, 3.0), DVec3::ZERO, [83, 61], aov)
}

/// Returns the cosine of the angle from the axis, and the distance to the source, of a point.
fn polar(light: &Light, point: DVec3) -> (f64, f64) {
    let Transform { translation, rotation, .. } = light.transform();
    let from_source = point - translation;
    let axis = rotation * DVec3::NEG_Z;
    (axis.dot(from_source.normalize()), from_source.length())
}

/// Returns the irradiance perpendicular to the light, light model section 6.
fn irradiance(light: &Light, point: DVec3) -> f64 {
    let (cosine, distance) = polar(light, point);
    let outer = light.get(CONE_ANGLE).to_radians();
    let inner = outer * (1.0 - light.get(CONE_SOFTNESS));
    let s = ((cosine - outer.cos()) / (inner.cos() - outer.cos())).clamp(0.0, 1.0);
    let decay = match light.get(DECAY) {
        Decay::None => 1.0,
        Decay::Linear => 1.0 / distance,
        Decay::InverseSquare => 1.0 / (distance * distance),
    };
    light.get(INTENSITY) * s * s * (3.0 - 2.0 * s) * decay
}

/// Computes the reflectance of a floor by the material model of glTF 2.0, appendix B.
fn brdf(to_light: DVec3, to_eye: DVec3, base: f64, metallic: f64, roughness: f64) -> f64 {
    let half = (to_light + to_eye).normalize();
    let alpha = (roughness * roughness).max(0.002);
    let a2 = alpha * alpha;
    let distribution = a2 / (PI * (half.y * half.y * (a2 - 1.0) + 1.0).powi(2));
    let smith = |n_x: f64| n_x + (n_x * n_x * (1.0 - a2) + a2).sqrt();
    // Separable Smith would be 1 / (smith(l) smith(v)); the height-correlated form is glTF's.
    let correlated = to_light.y * (smith(to_eye.y) - to_eye.y) + to_eye.y * (smith(to_light.y) - to_light.y);
    let f0 = 0.04 + (base - 0.04) * metallic;
    let fresnel = f0 + (1.0 - f0) * (1.0 - to_eye.dot(half)).powi(5);
    (1.0 - fresnel) * (1.0 - metallic) * base / PI + fresnel * distribution * 0.5 / correlated
}

/// Returns the largest difference between a beauty picture of the floor and `radiance`, relative to 1e-4 of it plus
/// 1e-5 of its maximum.
///
/// 1e-4: the smoothstep's slope at the edge of the cone, 1.5 over a range of 0.05 in the cosine, amplifies each of the
/// few 6e-8 by which the position is rounded to about 40. A roughness that is a multiple of a tenth is stored exactly.
fn worst_ratio(beauty: &Picture, radiance: impl Fn(DVec3) -> f64) -> f64 {
    let view = camera(Aov::Beauty);
    let pixels: Vec<_> = on_plane(beauty, &view, DVec3::Y, 0.0).map(|(p, c)| (radiance(p), c[0])).collect();
    let brightest = pixels.iter().map(|p| p.0).fold(0.0, f64::max);
    let lit = pixels.iter().filter(|p| p.0 > 0.01 * brightest).count();
    assert!(lit > 300, "only {lit} pixels are lit");
    pixels.iter().map(|(a, b)| (a - b).abs() / (1e-4 * a + 1e-5 * brightest)).fold(0.0, f64::max)
}

#[test]
fn radiance_is_the_closed_form() {
    let eye = camera(Aov::Beauty).camera.translation;
    for decay in [Decay::None, Decay::Linear, Decay::InverseSquare] {
        for (base, metallic, roughness) in [(1.0, 0.0, 1.0), (0.25, 0.0, 0.5), (1.0, 1.0, 0.4)] {
            let light = key().with(DECAY, decay);
            let source = light.transform().translation;
            let radiance = |point: DVec3| {
                let to_light = (source - point).normalize();
                let to_eye = (eye - point).normalize();
                let f = brdf(to_light, to_eye, base, metallic, roughness);
                f * irradiance(&light, point) * to_light.y
            };
            let scene = plane(base as f32, metallic as f32, roughness as f32);
            let beauty = picture(&scene, &camera(Aov::Beauty), std::slice::from_ref(&light));
            // A base color of 1/4 is stored as 127.5 / 255, rounded: its own half step is added.
            let storage = if base == 0.25 { 0.5 / 127.5 * 2.0 * 1e4 } else { 0.0 };
            let worst = worst_ratio(&beauty, radiance);
            assert!(worst <= 1.0 + storage, "{decay:?} {base} {metallic} {roughness}: {worst} of the tolerance");
            // Deliberate faults that the check must detect: no cosine; no 1 / pi; the profile's angle 1 % off.
            let flat = |p: DVec3| radiance(p) / (source - p).normalize().y;
            assert!(worst_ratio(&beauty, flat) > 100.0);
            assert!(worst_ratio(&beauty, |p| radiance(p) * PI) > 100.0);
            let wider = light.clone().with(CONE_ANGLE, light.get(CONE_ANGLE) * 1.01);
            let other = |p: DVec3| radiance(p) * irradiance(&wider, p) / irradiance(&light, p).max(1e-9);
            assert!(worst_ratio(&beauty, other) > 100.0);
        }
    }
}

#[test]
fn narrow_wide_hard_and_soft_cones_keep_their_edge() {
    for cone_angle in [0.5, 25.0, 80.0] {
        for cone_softness in [0.0, 1e-7, 0.5, 1.0] {
            let light = key().with(CONE_ANGLE, cone_angle).with(CONE_SOFTNESS, cone_softness).with(DECAY, Decay::None);
            let scene = plane(1.0, 0.0, 1.0);
            let view = camera(Aov::Visibility);
            let lit = picture(&scene, &view, std::slice::from_ref(&light));
            let beauty = picture(&scene, &camera(Aov::Beauty), std::slice::from_ref(&light));
            let edge = cone_angle.to_radians().cos();
            let [lit, beauty] = [&lit, &beauty].map(|picture| on_plane(picture, &view, DVec3::Y, 0.0));
            for ((point, value), (_, color)) in lit.zip(beauty) {
                if point.abs().max_element() > 19.9 {
                    continue;
                }
                let (cosine, _) = polar(&light, point);
                // f32 places a point of size 20 to 1e-6, which at distance 3 is 1e-6 rad.
                if (cosine.min(1.0).acos() - cone_angle.to_radians()).abs() > 1e-5 {
                    assert_eq!(value[3] == 1.0, cosine > edge, "{cone_angle} {cone_softness} {point}");
                    let bright = cosine.acos() < cone_angle.to_radians() * (1.0 - cone_softness).min(0.99);
                    assert!(!bright || color[0] > 0.0, "{cone_angle} {cone_softness} {point}");
                }
            }
        }
    }
}

#[test]
fn coordinates_in_the_light_are_the_closed_form() {
    let light = key().with(RANGE, Some(4.0));
    let scene = plane(1.0, 0.0, 1.0);
    let slope = light.get(CONE_ANGLE).to_radians().tan();
    let Transform { translation, rotation, .. } = light.transform();
    let aov = |aov| picture(&scene, &camera(aov), std::slice::from_ref(&light));
    let (ts, vws, directions) = (aov(Aov::T), aov(Aov::Vw), aov(Aov::Direction));
    let view = camera(Aov::T);
    let at = |picture| on_plane(picture, &view, DVec3::Y, 0.0).map(|(_, c)| c).collect::<Vec<_>>();
    let (vws, directions) = (at(&vws), at(&directions));
    let mut compared = 0;
    for (i, (point, t)) in on_plane(&ts, &view, DVec3::Y, 0.0).enumerate().filter(|(_, (_, t))| t[3] == 1.0) {
        let local = rotation.inverse() * (point - translation);
        // u x v = w with u forward, along -z, and w up, along +y: v points along -x.
        let vw = DVec3::new(-local.x, local.y, 0.0) / (-local.z * slope);
        // A point is known to a few ulps of 20, the size of the floor: 1e-5; v and w magnify by 1 / (3 slope).
        assert!((t[0] - -local.z / 4.0).abs() < 1e-5, "{point}");
        assert!((DVec3::new(vws[i][0], vws[i][1], 0.0) - vw).length() < 2e-5, "{point}");
        let direction = (translation - point).normalize();
        assert!((DVec3::new(directions[i][0], directions[i][1], directions[i][2]) - direction).length() < 1e-5);
        compared += 1;
    }
    assert!(compared > 300);
}

#[test]
fn a_light_ends_at_its_range() {
    let light = key().with(RANGE, Some(2.9));
    let slope = light.get(CONE_ANGLE).to_radians().tan();
    let Transform { translation, rotation, .. } = light.transform();
    let view = camera(Aov::T);
    let ts = picture(&plane(1.0, 0.0, 1.0), &view, std::slice::from_ref(&light));
    let mut ended = 0;
    for (point, t) in on_plane(&ts, &view, DVec3::Y, 0.0) {
        let local = rotation.inverse() * (point - translation);
        let in_cone = local.truncate().length() < -local.z * slope * 0.999;
        if in_cone && (-local.z - 2.9).abs() > 1e-4 {
            assert_eq!(t[3] == 1.0, -local.z < 2.9, "{point}");
            ended += usize::from(t[3] == 0.0);
        }
    }
    assert!(ended > 20, "the range cuts through the picture");
}

#[test]
fn lights_add_up() {
    let (a, b) = (key(), spot(DVec3::new(-1.0, 2.5, 0.0), DVec3::ZERO));
    let scene = plane(1.0, 0.0, 1.0);
    let beauty = |lights: &[Light]| picture(&scene, &camera(Aov::Beauty), lights);
    let (both, one, other) = (beauty(&[a.clone(), b.clone()]), beauty(&[a]), beauty(&[b]));
    for ((sum, a), b) in both.pixels.iter().zip(&one.pixels).zip(&other.pixels) {
        // One addition in f32, and one order.
        assert_eq!(sum[0], a[0] + b[0]);
    }
    assert!(both.pixels != one.pixels);
}

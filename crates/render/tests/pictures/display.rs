//! Tests of the bytes of a screen.

use glam::DVec3;
use render::{Aov, Background, FileNeeds, RenderError, View};
use scene::Material;

use crate::support::{filled, floor, instances, renderer, scene_of, spot, view};

/// Khronos PBR Neutral, as published, then sRGB (IEC 61966-2-1), scaled to 0 to 255.
fn expected(linear: DVec3) -> DVec3 {
    let (start, desaturation) = (0.8 - 0.04, 0.15);
    let low = linear.min_element();
    let mut color = linear - if low < 0.08 { low - 6.25 * low * low } else { 0.04 };
    let peak = color.max_element();
    if peak >= start {
        let d = 1.0 - start;
        let new_peak = 1.0 - d * d / (peak + d - start);
        color *= new_peak / peak;
        let g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
        color = color.lerp(DVec3::splat(new_peak), g);
    }
    let srgb = |c: f64| if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
    DVec3::new(srgb(color.x), srgb(color.y), srgb(color.z)) * 255.0
}

#[test]
fn radiance_is_tone_mapped_and_encoded() {
    let colors = [
        DVec3::ZERO,
        DVec3::splat(0.001),
        DVec3::new(0.02, 0.05, 0.3),
        DVec3::new(0.5, 0.2, 0.1),
        DVec3::splat(0.78),
        DVec3::new(0.9, 0.7, 0.4),
        DVec3::new(7.0, 1.0, 0.0),
        DVec3::splat(1e6),
    ];
    for color in colors {
        let view = view(DVec3::Y * 2.0, DVec3::ZERO, [3, 3], Aov::Beauty);
        let bytes = renderer(&filled(color)).render_display(&view, &[]).unwrap();
        let pixel = &bytes[16..20];
        let expected = expected(color);
        for (byte, expected) in pixel.iter().zip(expected.to_array()) {
            // Rounded to the nearest byte; f32's power function may fall on the other side of a half.
            assert!((f64::from(*byte) - expected).abs() <= 0.5 + 1e-2, "{color}: {pixel:?}, expected {expected}");
        }
        assert_eq!(pixel[3], 255);
    }
    // Deliberate fault that the check must detect: truncation instead of rounding has a larger error somewhere.
    assert!(colors.iter().any(|c| (expected(*c).x.floor() - expected(*c).x).abs() > 0.51));
}

/// One stop doubles the radiance before tone mapping, also in a file from another renderer's picture. Radiance too
/// bright for f32 is white.
#[test]
fn exposure_multiplies_radiance_before_tone_mapping() {
    let color = DVec3::new(0.02, 0.15, 0.4);
    let mut renderer = renderer(&filled(color));
    let view = view(DVec3::Y * 2.0, DVec3::ZERO, [3, 3], Aov::Beauty);
    let raw = renderer.render(&view, &[]).unwrap();
    for exposure in [-32.0, -6.5, -1.0, 0.0, 0.25, 1.0, 3.0, 20.0, 32.0] {
        let view = View { exposure, ..view.clone() };
        let shown = renderer.render_display(&view, &[]).unwrap();
        let file = raw.to_png(&view, &[], Background::Black).unwrap();
        let file = image::load_from_memory(&file).unwrap().into_rgb8();
        let pixels = [&shown[16..19], &file.get_pixel(1, 1).0];
        let off = |stops: f64| {
            let expected = expected(color * f64::exp2(stops)).to_array();
            let bytes = pixels.iter().flat_map(|pixel| pixel.iter().zip(expected));
            bytes.map(|(byte, expected)| (f64::from(*byte) - expected).abs()).fold(0.0, f64::max)
        };
        // Same tolerance as above. On the steepest part of the tone map, sRGB's linear part, a byte is 3e-4 of
        // radiance, and f32's roundings are far below a hundredth of that.
        assert!(off(exposure) <= 0.5 + 1e-2, "{exposure}: {pixels:?}");
        // Deliberate fault that the check must detect: a factor of e in place of 2.
        let fault = exposure * std::f64::consts::LOG2_E;
        assert!(exposure == 0.0 || exposure.abs() > 16.0 || off(fault) > 1.0, "{exposure}");
        assert_eq!(renderer.render(&view, &[]).unwrap(), raw, "values know no exposure");
    }
    let mut blinding = crate::support::renderer(&filled(DVec3::splat(1e37)));
    let view = View { exposure: 32.0, ..view };
    assert_eq!(blinding.render_display(&view, &[]).unwrap()[16..20], [255; 4]);
    let raw = blinding.render(&view, &[]).unwrap();
    let file = raw.to_png(&view, &[], Background::Black).unwrap();
    assert_eq!(image::load_from_memory(&file).unwrap().into_rgb8().get_pixel(1, 1).0, [255; 3]);
    for exposure in [-32.1, 33.0, f64::NAN, f64::INFINITY] {
        let refused = renderer.render_display(&View { exposure, ..view.clone() }, &[]);
        assert!(matches!(refused, Err(RenderError::InvalidView(_))), "{exposure}: {refused:?}");
    }
}

#[test]
fn the_background_is_black() {
    let view = view(DVec3::Y * 2.0, DVec3::Y * 9.0, [3, 3], Aov::Beauty);
    let scene = scene_of([floor(1.0, 0.0)], vec![Material::default()]);
    assert_eq!(renderer(&scene).render_display(&view, &[]).unwrap(), [0, 0, 0, 255].repeat(9));
}

/// A PNG holds the screen's picture, or the values in a readable form.
#[test]
fn files_hold_the_picture() {
    let mut renderer = renderer(&scene_of([floor(1.0, 0.0)], vec![Material::default()]));
    let view = view(DVec3::Y * 2.0, DVec3::ZERO, [4, 3], Aov::Beauty);
    let lights = instances(&[spot(DVec3::Y * 3.0, DVec3::ZERO)]);
    let decoded = |file: Vec<u8>| image::load_from_memory(&file).unwrap().into_rgb8();
    // The middle is nearest, so brightest.
    let depth = View { aov: Aov::Depth, ..view.clone() };
    let far = renderer.render(&depth, &lights).unwrap().to_png(&depth, &lights, Background::Black).unwrap();
    let shades: Vec<u8> = decoded(far).pixels().map(|pixel| pixel.0[0]).collect();
    assert_eq!(shades.iter().max(), Some(&255));
    let screen = renderer.render_display(&view, &lights).unwrap();
    let screen: Vec<u8> = screen.as_chunks::<4>().0.iter().flat_map(|pixel| pixel[..3].to_vec()).collect();
    // With or without an EXR, it has the bytes of the screen.
    for exr in [false, true] {
        let needs = FileNeeds::of(Aov::Beauty, Some(Background::Black), exr);
        let pixels = renderer.render_for_files(&view, &lights, needs, |_| {}).unwrap();
        assert_eq!(pixels.values().is_some(), exr);
        assert_eq!(decoded(pixels.to_png(&view, &lights, Background::Black).unwrap()).into_raw(), screen);
    }
    // Values of another renderer give the same, except for rounding in f32's power function.
    let beauty = renderer.render(&view, &lights).unwrap();
    let ours = decoded(beauty.to_png(&view, &lights, Background::Black).unwrap());
    assert!(ours.as_raw().iter().zip(&screen).all(|(a, b)| a.abs_diff(*b) <= 1));
    // Deliberate fault that the check must detect: one AOV in place of another.
    assert_ne!(beauty, renderer.render(&View { aov: Aov::Depth, ..view }, &lights).unwrap());
}

/// Positions are those of depths, by every method of drawing.
#[test]
fn positions_are_those_of_depths() {
    let mut renderer = renderer(&scene_of([floor(1.0, 0.0)], vec![Material::default()]));
    let view = view(DVec3::new(0.3, 2.0, 0.4), DVec3::ZERO, [9, 7], Aov::Position);
    let drawn = renderer.render(&view, &[]).unwrap();
    let tiled = renderer.render_for_files(&view, &[], FileNeeds::Values, |_| {}).unwrap();
    assert!(tiled.values() == Some(&drawn));
    let seen: Vec<_> = drawn.pixels.iter().filter(|pixel| pixel[3] > 0.0).collect();
    assert!(seen.len() > 9);
    for [x, y, z, _] in seen {
        // On the floor, within the error of a depth of 2.5: half a step of 1 / z over a near plane of 0.01, 2^-25 *
        // 2.5^2 / 0.01.
        assert!(y.abs() < 2e-5 && x.abs() <= 1.0 && z.abs() <= 1.0, "{x} {y} {z}");
    }
}

//! Alpha of textures whose values are known everywhere.

use glam::{Vec2, Vec3};

use super::{AlphaTest, AlphaTests, TexelWrap};

const TEST: AlphaTest = AlphaTest {
    width: 4,
    height: 4,
    wrap_u: TexelWrap::ClampToEdge,
    wrap_v: TexelWrap::ClampToEdge,
    ..AlphaTest::OF_ONE_TEXEL
};
/// Alpha grows along u and v, by 10 and 40 a texel.
const RAMP: [u8; 16] = [0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100, 110, 120, 130, 140, 150];
/// Sums of four products in f32, each rounded a few times, and uv with a rounding error for up to 8 texels.
const TOLERANCE: f32 = 1e-5;

fn at(test: &AlphaTest, texels: &[u8], u: f32, v: f32) -> f32 {
    let tests = AlphaTests { tests: &[], texels };
    255.0 * tests.texel_alpha(test, Vec2::new(u, v))
}

#[test]
fn between_texels_alpha_is_linear_either_way() {
    for (u, v) in [(0.2, 0.3), (0.5, 0.5), (0.125, 0.875), (0.6, 0.77)] {
        let expected = 10.0 * (4.0 * u - 0.5) + 40.0 * (4.0 * v - 0.5);
        assert!((at(&TEST, &RAMP, u, v) - expected).abs() < 255.0 * TOLERANCE, "{u}, {v}");
    }
    // Detects swapped rows and columns.
    assert!((at(&TEST, &RAMP, 0.2, 0.3) - at(&TEST, &RAMP, 0.3, 0.2)).abs() > 1.0);
}

#[test]
fn textures_continue_beyond_their_edges_as_they_wrap() {
    let with = |wrap| AlphaTest { wrap_u: wrap, wrap_v: wrap, ..TEST };
    for step in -40..40 {
        let u = step as f32 * 0.0625 + 0.03125;
        let close = |a: f32, b: f32| assert!((a - b).abs() < 255.0 * TOLERANCE, "{a} and {b} at {u}");
        let repeat = with(TexelWrap::Repeat);
        close(at(&repeat, &RAMP, u, 0.4), at(&repeat, &RAMP, u + 1.0, 0.4));
        close(at(&repeat, &RAMP, 0.4, u), at(&repeat, &RAMP, 0.4, u - 3.0));
        let mirror = with(TexelWrap::MirroredRepeat);
        close(at(&mirror, &RAMP, u, 0.4), at(&mirror, &RAMP, -u, 0.4));
        close(at(&mirror, &RAMP, 0.4, u), at(&mirror, &RAMP, 0.4, 2.0 - u));
        let edge = with(TexelWrap::ClampToEdge);
        close(at(&edge, &RAMP, u, 0.4), at(&edge, &RAMP, u.clamp(0.0, 1.0), 0.4));
        close(at(&edge, &RAMP, 0.4, u), at(&edge, &RAMP, 0.4, u.clamp(0.0, 1.0)));
    }
    // At a repeat the last texel is next to the first, and each counts half.
    assert!((at(&with(TexelWrap::Repeat), &RAMP, 0.0, 0.125) - 15.0).abs() < 255.0 * TOLERANCE);
    assert!((at(&with(TexelWrap::MirroredRepeat), &RAMP, 0.0, 0.125) - 0.0).abs() < 255.0 * TOLERANCE);
}

#[test]
fn nearest_filtering_blends_no_texels() {
    let nearest = AlphaTest { nearest: true, wrap_u: TexelWrap::Repeat, wrap_v: TexelWrap::MirroredRepeat, ..TEST };
    for (u, v, expected) in [(0.24, 0.0, 0.0), (0.26, 0.0, 10.0), (-0.01, 0.3, 70.0), (1.3, -0.3, 50.0)] {
        assert!((at(&nearest, &RAMP, u, v) - expected).abs() < 255.0 * TOLERANCE, "{u}, {v}");
    }
}

#[test]
fn a_triangle_has_holes_where_the_product_is_below_its_tests_cutoff() {
    let texels: Vec<u8> = RAMP.into_iter().chain([255]).collect();
    let solid = AlphaTest { offset: 16, width: 1, height: 1, ..TEST };
    let tests = [
        // Triangles 0 to 2: holes below 50 / 255 on the ramp.
        AlphaTest { cutoff: 50.0 / 255.0, ..TEST },
        // Triangle 3: no holes. Triangles 4 and 5: holes where the corners' alpha is below 0.8.
        AlphaTest { first_triangle: 3, first_index: 0, cutoff: 0.5, ..solid },
        AlphaTest { first_triangle: 4, first_index: 0, factor: 0.5, cutoff: 0.4, ..solid },
    ];
    let tests = AlphaTests { tests: &tests, texels: &texels };
    assert_eq!([0, 1, 2, 3, 4, 5, 9].map(|triangle| tests.test_of(triangle)), [0, 0, 0, 1, 2, 2, 2]);
    let corners = [Vec3::new(0.125, 0.125, 1.0), Vec3::new(0.875, 0.125, 1.0), Vec3::new(0.125, 0.875, 0.5)];
    // On the ramp alpha is 30 times the second weight, and half of 120 at the third corner.
    for (weights, holes) in [
        (Vec3::X, [true, false, false]),
        (Vec3::Y, [true, false, false]),
        (Vec3::Z, [false, false, true]),
        (Vec3::new(0.5, 0.0, 0.5), [true, false, true]),
        (Vec3::new(0.0, 0.5, 0.5), [false, false, true]),
        (Vec3::new(0.0, 0.7, 0.3), [true, false, false]),
    ] {
        assert_eq!([2, 3, 5].map(|triangle| tests.has_hole(triangle, corners, weights)), holes, "{weights}");
    }
}

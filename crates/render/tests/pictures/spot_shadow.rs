//! Compares shadows of a spotlight with those by similar triangles.

use glam::{DAffine3, DQuat, DVec3, Vec2};
use light::parameters::{CONE_ANGLE, DECAY};
use light::{Decay, Light};
use render::{Aov, View};
use scene::{Image, Material, Primitive, Projection, Sampler, TextureRef};

use crate::support::{floor, on_plane, picture, scene_of, spot, square, view};

/// Returns a white floor and above it a square of half size 0.25 at height 1.
fn blocker() -> scene::Scene {
    scene_of([floor(4.0, 0.0), floor(0.25, 1.0)], vec![Material { double_sided: true, ..Material::default() }])
}

/// Returns a spotlight that shines straight down from height 3 with an angle of 40 degrees.
fn lamp() -> Light {
    spot(DVec3::Y * 3.0, DVec3::ZERO).with(CONE_ANGLE, 40.0).with(DECAY, Decay::None)
}

/// Returns a view from below the blocker, in which the blocker hides nothing of the floor.
fn camera() -> View {
    view(DVec3::new(0.0, 0.9, 3.0), DVec3::ZERO, [211, 151], Aov::Visibility)
}

/// Returns the number of wrong pixels of the floor, farther than two texels from the edge of a square shadow of
/// `half_size`, and number in that shadow.
fn wrong(half_size: f64) -> (usize, usize) {
    let view = camera();
    let lit = picture(&blocker(), &view, &[lamp()]);
    let texel = 2.0 * 3.0 * 40.0_f64.to_radians().tan() / 2048.0;
    let mut count = (0, 0);
    for (point, value) in on_plane(&lit, &view, DVec3::Y, 0.0).filter(|(_, v)| v[3] == 1.0) {
        let outside = point.x.abs().max(point.z.abs()) - half_size;
        if point.length() < 2.0 && outside.abs() > 2.0 * texel {
            count.0 += usize::from(value[0] != if outside > 0.0 { 1.0 } else { 0.0 });
            count.1 += usize::from(outside < 0.0);
        }
    }
    count
}

#[test]
fn a_square_casts_the_square_that_similar_triangles_say() {
    // The blocker is 2 from the source, the floor 3: the shadow is 3 / 2 as large.
    let (wrong_pixels, in_shadow) = wrong(0.25 * 1.5);
    assert!(in_shadow > 200, "{in_shadow}");
    assert_eq!(wrong_pixels, 0);
    // Deliberate faults that the check must detect: no perspective, and a shadow three texels too large.
    assert!(wrong(0.25).0 > 0);
    assert!(wrong(0.25 * 1.5 + 3.0 * 2.46e-3).0 > 0);
}

/// Maps are fitted to casters with visible shadows, which a floor is not. Beyond the map a floor is lit, however much
/// farther or nearer it is there under a slanted light.
#[test]
fn a_floor_is_lit_beyond_what_stands_on_it() {
    let view = camera();
    let source = DVec3::new(0.9, 3.0, 0.6);
    let lamp = spot(source, DVec3::ZERO).with(CONE_ANGLE, 40.0).with(DECAY, Decay::None);
    let lit = picture(&blocker(), &view, &[lamp]);
    // The point where light to the floor passes the blocker's height, two thirds of the way.
    let aside = |point: DVec3| {
        let at = source + (point - source) * (2.0 / 3.0);
        at.x.abs().max(at.z.abs()) - 0.25
    };
    let mut counts = [0, 0];
    for (point, value) in on_plane(&lit, &view, DVec3::Y, 0.0).filter(|(_, v)| v[3] == 1.0) {
        let outside = aside(point);
        if outside.abs() > 0.02 {
            assert_eq!(value[0], if outside > 0.0 { 1.0 } else { 0.0 }, "{point}");
            counts[usize::from(outside > 0.0)] += 1;
        }
    }
    assert!(counts[0] > 100 && counts[1] > 5_000, "{counts:?}");
}

/// From straight down to grazing, near the camera's near plane and far from it. Two coincident planes, such as a carpet
/// on its floor, do not shadow each other either.
#[test]
fn a_bare_plane_never_shadows_itself() {
    let bare = scene_of([floor(50.0, 0.0)], vec![Material::default()]);
    let carpeted = scene_of([floor(50.0, 0.0), floor(1.3, 0.0)], vec![Material::default()]);
    for (height, znear) in [4.0, 1.0, 0.2, 0.05].into_iter().flat_map(|h| [(h, 1e-3), (h, 0.05)]) {
        let light = spot(DVec3::new(-1.5, height, 0.4), DVec3::X).with(CONE_ANGLE, 60.0);
        let mut view = view(DVec3::new(0.4, 0.7, 3.0), DVec3::ZERO, [173, 127], Aov::Visibility);
        view.camera.projection = Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear, zfar: None };
        let counts = |scene| {
            let lit = picture(scene, &view, std::slice::from_ref(&light));
            let inside = lit.pixels.iter().filter(|p| p[3] == 1.0).count();
            let dark = lit.pixels.iter().filter(|p| p[3] == 1.0 && p[0] < 1.0).count();
            assert!(inside > 1000);
            dark
        };
        assert_eq!([&bare, &carpeted].map(counts), [0, 0], "height {height}, near plane {znear}");
        // Deliberate fault that the check must detect: a carpet that hangs over its floor.
        let hanging = scene_of([floor(50.0, 0.0), floor(1.3, 0.04)], vec![Material::default()]);
        assert!(counts(&hanging) > 10, "height {height}");
    }
}

#[test]
fn contact_shadows_reach_the_contact() {
    // An upright wall on the floor, lit from behind at 45 degrees: the floor in front of it is dark from its foot on.
    let wall = DAffine3::from_scale_rotation_translation(
        DVec3::splat(0.5),
        DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2),
        DVec3::Y * 0.5,
    );
    let scene =
        scene_of([floor(4.0, 0.0), (square(), wall)], vec![Material { double_sided: true, ..Material::default() }]);
    let light = spot(DVec3::new(0.0, 3.0, -3.0), DVec3::ZERO).with(CONE_ANGLE, 30.0);
    let view = view(DVec3::new(0.0, 1.5, 2.0), DVec3::ZERO, [151, 401], Aov::Visibility);
    let lit = picture(&scene, &view, &[light]);
    let texel = 2.0 * 18.0_f64.sqrt() * 30.0_f64.to_radians().tan() / 2048.0;
    let (mut compared, mut leaking) = (0, 0);
    for (point, value) in on_plane(&lit, &view, DVec3::Y, 0.0) {
        // In front of the wall, from two texels (sqrt 2 longer on the floor) off its foot; the shadow is 1 long.
        if point.x.abs() < 0.4 && point.z > 3.0 * texel && point.z < 0.5 {
            compared += 1;
            leaking += usize::from(value[0] > 0.0);
        }
    }
    assert!(compared > 1000);
    assert_eq!(leaking, 0, "of {compared}");
}

#[test]
fn alpha_tested_casters_let_light_through() {
    // The blocker's left half is a hole.
    let (panel, placement) = floor(0.5, 1.0);
    let uvs = panel.positions.iter().map(|p| Vec2::new(p.x * 0.5 + 0.5, 0.5)).collect();
    let panel = Primitive { uvs, material: 1, ..panel };
    let texture = TextureRef { image: 0, sampler: Sampler { nearest: true, ..Sampler::default() } };
    let alpha_tested = Material {
        alpha_cutoff: Some(0.5),
        base_color_texture: Some(texture),
        double_sided: true,
        ..Material::default()
    };
    let mut scene = scene_of([floor(4.0, 0.0), (panel, placement)], vec![Material::default(), alpha_tested]);
    scene.images.push(Image { width: 2, height: 1, rgba8: vec![255, 255, 255, 0, 255, 255, 255, 255] });
    let view = camera();
    let lit = picture(&scene, &view, &[lamp()]);
    let mut seen = [0, 0];
    for (point, value) in on_plane(&lit, &view, DVec3::Y, 0.0).filter(|(p, _)| p.z.abs() < 0.6) {
        if (0.05..0.7).contains(&point.x.abs()) {
            let lit = point.x < 0.0;
            assert_eq!(value[0] == 1.0, lit, "{point}");
            seen[usize::from(lit)] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n > 100));
}

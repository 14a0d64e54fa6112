//! Tests of BendyLights in pictures: one made from a spotlight equals it, and its AOVs are those of the light model in
//! f64.

use glam::{DAffine3, DQuat, DVec3};
use light::parameters::{CONE_SOFTNESS, DECAY, DIRECTION, END_MODE, FRAME, INTENSITY, RANGE, SCALE, TRANSLATION};
use light::{CheckedLight, Decay, Light, LightError, Tube, bend};
use render::{Aov, Picture, RenderError, View};
use scene::{Material, Scene};

use crate::support::{EPS, floor, instances, picture, ray_in_world, renderer, scene_of, spot, square, view};

/// Returns a floor with two tilted squares above it, in a glossy and a rough material.
fn tilted() -> Scene {
    let tilt = |x: f64, y: f64, z: f64, angle: f64| {
        let rotation = DQuat::from_rotation_z(angle) * DQuat::from_rotation_x(0.5 * angle);
        (square(), DAffine3::from_scale_rotation_translation(DVec3::splat(0.3), rotation, DVec3::new(x, y, z)))
    };
    let material = Material { roughness: 0.4, double_sided: true, ..Material::default() };
    scene_of([floor(3.0, 0.0), tilt(-0.4, 0.5, 0.2, 0.6), tilt(0.5, 0.8, -0.3, -0.9)], vec![material])
}

const EYE: DVec3 = DVec3::new(2.0, 2.5, 3.5);

/// True if in the 3 x 3 pixels around `pixel` either light's visibility is not the same whole number: the shadow's
/// edge, which two maps of different orientation filter differently.
fn on_boundary(a: &Picture, b: &Picture, pixel: usize) -> bool {
    let (width, height) = (a.width as usize, a.height as usize);
    let (x, y) = (pixel % width, pixel / width);
    let around = (y.saturating_sub(1)..(y + 2).min(height))
        .flat_map(|j| (x.saturating_sub(1)..(x + 2).min(width)).map(move |i| j * width + i));
    let key = |p: &Picture, i: usize| [p.pixels[i][0], p.pixels[i][3]];
    let whole = key(a, pixel);
    around.into_iter().any(|i| key(a, i) != whole || key(b, i) != whole)
}

/// Returns the largest difference in radiance off the shadow edge, and the share of lit pixels on it.
fn difference(spot: &Light, bent: &Light) -> (f32, f64) {
    let scene = tilted();
    let shoot = |aov, lights: &[Light]| picture(&scene, &view(EYE, DVec3::Y * 0.3, [200, 150], aov), lights);
    let (spot, bent) = ([spot.clone()], [bent.clone()]);
    let visibility = [shoot(Aov::Visibility, &spot), shoot(Aov::Visibility, &bent)];
    let radiance = [shoot(Aov::Beauty, &spot), shoot(Aov::Beauty, &bent)];
    let lit = visibility[0].pixels.iter().filter(|p| p[0] > 0.0).count();
    assert!(lit > 3000, "the light hits the scene: {lit}");
    let (mut worst, mut boundary) = (0.0_f32, 0);
    for pixel in 0..radiance[0].pixels.len() {
        if on_boundary(&visibility[0], &visibility[1], pixel) {
            boundary += 1;
            continue;
        }
        for channel in 0..3 {
            worst = worst.max((radiance[0].pixels[pixel][channel] - radiance[1].pixels[pixel][channel]).abs());
        }
    }
    (worst, boundary as f64 / lit as f64)
}

/// A spotlight and the BendyLight made from it differ by less than 1e-4 of a radiance up to 1; the promise is 1/255.
/// Both have the same formulas in f32 except for the cosine of the profile and the distance. 1e-4 leaves room for a
/// thousand roundings, and would still show any wrong factor.
#[test]
fn a_bent_spotlight_is_that_spotlight() {
    let base = spot(DVec3::new(-1.0, 3.0, 1.0), DVec3::new(0.1, 0.0, 0.0));
    let with_range = base.clone().with(RANGE, Some(6.0));
    let cinematic = base.clone().with(DECAY, Decay::None).with(INTENSITY, 2.0).with(CONE_SOFTNESS, 0.6);
    let linear = base.clone().with(DECAY, Decay::Linear).with(INTENSITY, 4.0);
    // 250 segments are more slabs than one turn maps.
    let cases = [(&base, 3), (&with_range, 1), (&with_range, 3), (&cinematic, 5), (&linear, 8), (&with_range, 250)];
    for (light, segments) in cases {
        let (worst, boundary) = difference(light, &bend(light, segments).expect("valid"));
        assert!(worst < 1e-4, "{segments} segments: {worst} off {light:?}");
        assert!(boundary < 0.25, "{boundary} of the lit pixels are left out");
    }
    // Deliberate faults that the check must detect: no decay, and a cone one percent wider.
    let bent = bend(&with_range, 3).expect("valid");
    assert!(difference(&with_range, &bent.clone().with(DECAY, Decay::None)).0 > 1.0 / 255.0);
    let wider = bent.map_points(|_, point| point.radius *= 1.01);
    assert!(difference(&with_range, &wider).0 > 1.0 / 255.0);
}

/// Returns a light of three segments that wind through the scene.
fn winding() -> Light {
    let points = [(0., 0., 0.), (0.2, 0.5, -0.9), (-0.7, 0.1, -1.9), (0.5, -0.3, -2.9), (0.9, 0.2, -4.0)];
    let points = points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
    Light::bendy(points, vec![0.2, 0.35, 0.45, 0.6, 1.2])
        .with_transform(spot(DVec3::new(-1.0, 3.0, 1.0), DVec3::ZERO).transform())
}

/// Returns the largest error of the AOVs t, vw and direction relative to their bound, and the number of compared
/// pixels.
fn worst_over_bound(light: &Light, shown: &Light) -> (f64, usize) {
    let scene = tilted();
    let shoot = |aov, light: &Light| {
        let view: View = view(EYE, DVec3::Y * 0.3, [240, 180], aov);
        (picture(&scene, &view, std::slice::from_ref(light)), view)
    };
    let (depth, view) = shoot(Aov::Depth, light);
    let [t, vw, direction] = [Aov::T, Aov::Vw, Aov::Direction].map(|aov| shoot(aov, shown).0);
    let tube = Tube::new(light).expect("valid");
    let size = tube.placement.world_per_tube;
    let (mut worst, mut count) = (0.0_f64, 0);
    for (i, pixel) in depth.pixels.iter().enumerate() {
        let (origin, ray) = ray_in_world(&view, i % 240, i / 240);
        let world = origin + ray * f64::from(pixel[0]);
        let q = tube.placement.tube_from_world(world);
        let Some(root) = tube.nearest_root(q) else { continue };
        // A pixel within rounding of the tube's edge may be on either side.
        let rim = root.r.length() / root.radius > 1.0 - 1e-4;
        if rim || t.pixels[i][3] == 0.0 {
            assert!(rim, "pixel {i} lies in the light, and the picture says it does not");
            continue;
        }
        count += 1;
        let segment = &tube.segments[root.segment].curve;
        let speed = 2.0 * segment.d(root.u).length();
        let bend = segment.u_hat_derivative(root.u, root.u_hat).dot(root.r) / speed;
        let length = segment.d0.length() + segment.d1.length();
        // Light model, section 5; positions pass through f32 at the camera's distance and the scene's size.
        let reach = (pixel[0] as f64 * ray.length() + scene_reach()) / size;
        let cond = (root.r.length() + length) / (speed * (1.0 - bend)) * (1.0 + reach);
        let expected = tube.tube_point(&root);
        let d = |a: f32, b: f64| (f64::from(a) - b).abs();
        let errors = [
            d(t.pixels[i][0], expected.t),
            d(vw.pixels[i][0], expected.v) * root.radius,
            d(vw.pixels[i][1], expected.w) * root.radius,
            d(direction.pixels[i][0], expected.direction.x),
            d(direction.pixels[i][1], expected.direction.y),
            d(direction.pixels[i][2], expected.direction.z),
        ];
        worst = errors.into_iter().fold(worst, |w, e| w.max(e / (16.0 * EPS * cond)));
    }
    (worst, count)
}

fn scene_reach() -> f64 {
    DVec3::new(3.0, 0.6, 3.0).length()
}

#[test]
fn aovs_are_the_models() {
    let light = winding();
    for frame in [light::FrameMode::RotationMinimizing, light::FrameMode::Up] {
        for direction in [light::DirectionMode::Tube, light::DirectionMode::Path] {
            let light = light.clone().with(FRAME, frame).with(DIRECTION, direction);
            let (worst, count) = worst_over_bound(&light, &light);
            assert!(count > 1000, "only {count} pixels lie in the light");
            assert!(worst <= 1.0, "{worst} times the bound with {frame:?}, {direction:?}");
        }
    }
    // Deliberate fault that the check must detect: a control point moved by a ten-thousandth of the light's length.
    let moved = light.clone().map_points(|i, point| point.position.x += if i == 2 { 4e-4 } else { 0.0 });
    assert!(worst_over_bound(&light, &moved).0 > 1.0);
}

/// No AOV has NaN or infinity (`picture` asserts it) under valid but extreme lights.
#[test]
fn extreme_lights_have_no_nan() {
    let bright = winding().map_points(|_, point| {
        (point.intensity, point.color) = (1e300, DVec3::splat(1e300));
    });
    let at_a_surface = bright.clone().with(TRANSLATION, DVec3::ZERO).with(DECAY, Decay::InverseSquare);
    let dark = winding().map_points(|i, point| point.intensity = [-1.0, 1.0, -1e300, 0.0, 1e-300][i]);
    let thin = winding().map_points(|_, point| point.radius = 0.0);
    let pointed = winding()
        .map_points(|i, point| point.radius = [0.0, 0.3, 0.0, 0.4, 0.0][i])
        .with(END_MODE, light::EndMode::Extend);
    let tiny = winding().with(SCALE, 1e-9);
    let huge = winding().with(SCALE, 1e7);
    let corner = {
        let second = winding().points()[1].position;
        winding().map_points(|i, point| point.position = if i == 2 { second } else { point.position })
    };
    let many = bend(&spot(DVec3::new(-1.0, 3.0, 1.0), DVec3::ZERO), 250).expect("valid");
    let all = [bright, at_a_surface, dark, thin, pointed, tiny, huge, corner, many];
    for light in all {
        for frame in [light::FrameMode::RotationMinimizing, light::FrameMode::Up] {
            let light = [light.clone().with(FRAME, frame)];
            for aov in [Aov::Beauty, Aov::T, Aov::Vw, Aov::Direction, Aov::Visibility] {
                picture(&tilted(), &view(EYE, DVec3::Y * 0.3, [41, 31], aov), &light);
            }
        }
    }
    picture(&Scene::default(), &view(EYE, DVec3::ZERO, [5, 4], Aov::Visibility), &[winding()]);
}

/// A light out of f32's reach is refused. A light that folds is an error before it gets to a renderer.
#[test]
fn impossible_lights_are_refused() {
    let refused = |light: Light| {
        let view = view(EYE, DVec3::ZERO, [5, 4], Aov::Visibility);
        renderer(&tilted()).render(&view, &instances(&[light])).expect_err("refused")
    };
    let far = DVec3 { x: 1e200, ..winding().transform().translation };
    assert!(matches!(refused(winding().with(TRANSLATION, far)), RenderError::OutOfReach(_)));
    assert!(matches!(refused(winding().with(SCALE, 1e-30)), RenderError::OutOfReach(_)));
    let folded = winding().map_points(|i, point| point.radius = if i == 2 { 9.0 } else { point.radius });
    assert!(matches!(CheckedLight::new(folded), Err(LightError::Fold { .. })));
}

/// The world moved by a million units, lights included, gives the same picture, because everything is composed in f64.
/// Shadows may differ where rounding of the offset, 1e-10, moves a texel.
#[test]
fn far_from_the_origin_nothing_changes() {
    let offset = DVec3::new(1e6, -2e6, 3e6);
    let shoot = |offset: DVec3| {
        let mut scene = tilted();
        for node in &mut scene.nodes {
            node.parent_from_local = DAffine3::from_translation(offset) * node.parent_from_local;
        }
        let light = winding().with(TRANSLATION, winding().transform().translation + offset);
        picture(&scene, &view(EYE + offset, DVec3::Y * 0.3 + offset, [120, 90], Aov::Beauty), &[light])
    };
    let (near, far) = (shoot(DVec3::ZERO), shoot(offset));
    let differ = near.pixels.iter().zip(&far.pixels).filter(|(a, b)| (a[0] - b[0]).abs() > 1e-4).count();
    assert!(differ <= near.pixels.len() / 500, "{differ} pixels differ");
}

/// A change of color, intensity or decay draws no shadow map; one of shape draws one; no change draws none.
#[test]
fn shadow_maps_are_kept_while_the_shape_is() {
    let mut renderer = renderer(&tilted());
    let view = view(EYE, DVec3::ZERO, [9, 7], Aov::Beauty);
    let mut shadows_after = |light: Light| {
        renderer.render(&view, &instances(&[light])).expect("drawn");
        (renderer.counts().shadow, renderer.counts().gbuffer)
    };
    let light = winding();
    assert_eq!(shadows_after(light.clone()), (1, 1));
    assert_eq!(shadows_after(light.clone()), (1, 1));
    assert_eq!(shadows_after(light.clone().map_points(|_, point| point.color = DVec3::X)), (1, 1));
    assert_eq!(shadows_after(light.clone().map_points(|_, point| point.intensity = 2.0)), (1, 1));
    assert_eq!(shadows_after(light.clone().with(DECAY, Decay::Linear).with(CONE_SOFTNESS, 0.7)), (1, 1));
    let moved = light.map_points(|i, point| point.position.x += if i == 4 { 0.1 } else { 0.0 });
    assert_eq!(shadows_after(moved), (2, 1));
}

/// Returns the number of pixels in which a floor wrongly shadows itself, and the number of its pixels inside the light,
/// which shines straight down.
fn self_shadowed(light: &Light) -> (usize, usize) {
    let scene = scene_of([floor(1.0, 0.0)], vec![Material::default()]);
    let seen = view(DVec3::new(0.3, 1.5, 0.6), DVec3::ZERO, [160, 120], Aov::Visibility);
    let visibility = picture(&scene, &seen, std::slice::from_ref(light));
    let inside = visibility.pixels.iter().filter(|pixel| pixel[3] == 1.0);
    (inside.clone().filter(|pixel| pixel[0] < 1.0).count(), inside.count())
}

/// Returns a light two units above a floor, with control points at these distances down its axis.
fn straight_down(depths: &[f64], radii: &[f64], lean: f64) -> Light {
    Light::bendy(depths.iter().map(|&z| DVec3::new(0.0, 0.0, -z)).collect(), radii.to_vec())
        .with_transform(spot(DVec3::new(2.0 * lean, 2.0, lean), DVec3::ZERO).transform())
}

/// At coincident control points the curve's speed is zero. Points beyond are lit all the same.
#[test]
fn coincident_points_shadow_nothing() {
    let (shadowed, inside) = self_shadowed(&straight_down(&[0.0, 1.5, 1.5, 3.0], &[0.3; 4], 0.0));
    assert!(inside > 1000 && shadowed == 0, "{shadowed} of {inside} lie in shadow");
}

/// A triangle's edge through the middle of a bulging tube is S-shaped on the shadow map, and its middle lies on its
/// chord. It is split all the same.
#[test]
fn an_edge_through_the_axis_is_split() {
    for lean in [0.2, 0.4, 0.6] {
        let light = straight_down(&[0.0, 1.1, 2.2, 3.3, 4.4], &[0.05, 0.8, 0.05, 0.05, 0.05], lean);
        let (shadowed, inside) = self_shadowed(&light);
        assert!(inside > 100 && shadowed == 0, "{shadowed} of {inside} lie in shadow at a lean of {lean}");
    }
}

/// A tube thinner than f32 resolves is drawn, even if as noise. It does not make triangles split into more pieces than
/// a buffer holds.
#[test]
fn a_tube_as_thin_as_rounding_is_drawn() {
    for radius in [1e-6, 1e-9, 1e-12] {
        let (_, inside) = self_shadowed(&winding().map_points(|_, point| point.radius = radius));
        assert!(inside < 10, "{inside}");
    }
}

/// A spotlight with negative intensity is dark, like the BendyLight made from it.
#[test]
fn no_light_takes_light_away() {
    let below = spot(DVec3::new(-1.0, 3.0, 1.0), DVec3::ZERO).with(INTENSITY, -3.0);
    let seen = view(EYE, DVec3::ZERO, [40, 30], Aov::Beauty);
    let dark = |lights: &[Light]| {
        let beauty = picture(&tilted(), &seen, lights);
        beauty.pixels.iter().all(|pixel| pixel[..3] == [0.0; 3])
    };
    assert!(dark(std::slice::from_ref(&below)) && dark(&[bend(&below, 3).expect("valid")]));
}

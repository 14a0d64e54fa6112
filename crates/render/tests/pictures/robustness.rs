//! Tests of valid but extreme input.

use glam::{DAffine3, DQuat, DVec3, Vec3, Vec4};
use light::parameters::{CONE_ANGLE, INTENSITY, RANGE, SCALE, TRANSLATION};
use light::{CheckedLight, Light, LightError, SceneBounds};
use render::{Aov, RenderError, View};
use scene::{Camera, Material, Primitive, Projection, Scene};

use crate::support::{instances, oblique, picture, renderer, scene_of, spot, square, tables, view};

const ALL: [Aov; 7] = [Aov::Beauty, Aov::Depth, Aov::Normal, Aov::T, Aov::Vw, Aov::Direction, Aov::Visibility];

#[test]
fn every_size_works() {
    let lights = instances(&[spot(DVec3::new(1.0, 3.0, 0.5), DVec3::ZERO)]);
    let mut renderer = renderer(&tables());
    for size in [[1, 1], [1, 7], [5, 1], [63, 65], [257, 3], [1, 1]] {
        for aov in ALL {
            let picture = renderer.render(&oblique(size, aov), &lights).unwrap();
            assert_eq!(picture.pixels.len(), (size[0] * size[1]) as usize);
            assert!(picture.pixels.iter().flatten().all(|x| x.is_finite()));
            assert!(picture.pixels.iter().any(|p| p[3] == 1.0), "{aov:?} {size:?} is empty");
        }
    }
}

#[test]
fn rows_come_from_the_top_and_columns_from_the_left() {
    // A patch right of the center and nearer than it, seen from above: in the lower right of the picture.
    let patch = (
        square(),
        DAffine3::from_scale_rotation_translation(DVec3::splat(0.5), DQuat::IDENTITY, DVec3::new(1.0, 0.0, 1.0)),
    );
    let camera = view(DVec3::new(0.0, 6.0, 0.1), DVec3::ZERO, [9, 9], Aov::Depth);
    let depths = picture(&scene_of([patch], vec![Material::default()]), &camera, &[]);
    let there: Vec<_> = (0..81).filter(|&i| depths.pixels[i][3] == 1.0).collect();
    assert!(!there.is_empty());
    assert!(there.iter().all(|i| i % 9 > 4 && i / 9 > 4), "{there:?}");
}

/// The depth complexity is so great that the device gets the scene in parts, which begin in the middle of a material.
/// Without parts, as with two sheets, the picture is the same.
#[test]
fn the_topmost_of_many_sheets_is_seen() {
    let camera = |aov| view(DVec3::new(0.0, 3.0, 0.1), DVec3::ZERO, [301, 301], aov);
    let stack = |sheets: u32| {
        let mut stack = Primitive::default();
        for sheet in 0..sheets {
            let height = sheet as f32 / (sheets - 1) as f32;
            let lean = Vec3::new(height - 0.5, 1.0, 0.3 * height).normalize();
            let square = square();
            stack.indices.extend(square.indices.iter().map(|index| index + 4 * sheet));
            stack.positions.extend(square.positions.iter().map(|position| position.with_y(height)));
            stack.normals.extend([lean; 4]);
        }
        scene_of([(stack, DAffine3::IDENTITY)], vec![Material::default()])
    };
    let topmost = Vec3::new(0.5, 1.0, 0.3).normalize().extend(1.0);
    let pictures = |aov| [600, 2].map(|sheets| picture(&stack(sheets), &camera(aov), &[]).pixels);
    let [normals, depths] = [Aov::Normal, Aov::Depth].map(pictures);
    // Normals are packed to 2^-15 along each axis.
    let is_topmost = |pixel: &usize| Vec4::from(normals[1][*pixel]).distance(topmost) < 1e-4;
    let on_top: Vec<usize> = (0..normals[1].len()).filter(is_topmost).collect();
    assert!(on_top.len() > normals[1].len() / 4, "{} pixels", on_top.len());
    // It is the same triangle.
    for [many, few] in [normals, depths] {
        assert!(on_top.iter().all(|&pixel| many[pixel] == few[pixel]));
    }
}

#[test]
fn degenerate_geometry_has_no_nan() {
    let opposed = Primitive { normals: vec![Vec3::Y, Vec3::NEG_Y, Vec3::Y, Vec3::NEG_Y], ..square() };
    let unlit = Primitive { normals: vec![Vec3::ZERO; 4], ..square() };
    let sliver = Primitive { indices: vec![0, 0, 1, 0, 1, 1, 0, 1, 2], ..square() };
    let parts = [
        (opposed, DAffine3::IDENTITY),
        (unlit, DAffine3::from_translation(DVec3::new(0.3, 0.4, 0.0))),
        (sliver, DAffine3::from_translation(DVec3::Y * 0.8)),
        (square(), DAffine3::from_scale(DVec3::new(1.0, 0.0, 0.0))),
        (square(), DAffine3::from_scale(DVec3::ZERO)),
        (square(), DAffine3::from_scale(DVec3::new(1e-30, 1.0, 1.0))),
        (Primitive::default(), DAffine3::IDENTITY),
    ];
    for roughness in [0.0, 1.0] {
        for metallic in [0.0, 1.0] {
            let material = Material { roughness, metallic, double_sided: true, ..Material::default() };
            let mut scene = scene_of(parts.clone(), vec![material]);
            scene.fill.sky = DVec3::ONE;
            // Sources on a surface, in its plane, at a vertex, behind the camera; intensities at both ends.
            let sources = [DVec3::ZERO, DVec3::X * 3.0, DVec3::new(1.0, 0.0, 1.0), DVec3::new(2.0, 3.0, 4.1)];
            for (source, intensity) in sources.into_iter().zip([1e300, 0.0, -1e300, 1e-300]) {
                let light = spot(source, DVec3::NEG_Y).with(INTENSITY, intensity).with(CONE_ANGLE, 89.9);
                for aov in ALL {
                    picture(&scene, &oblique([41, 31], aov), std::slice::from_ref(&light));
                }
            }
            // Edge on, and from inside a surface.
            for eye in [DVec3::X * 3.0, DVec3::new(0.2, 0.0, 0.1)] {
                picture(&scene, &view(eye, DVec3::ZERO, [41, 31], Aov::Beauty), &[]);
            }
        }
    }
}

#[test]
fn tiny_and_huge_scenes_are_seen_like_others() {
    for scale in [1e-9, 1.0, 1e9] {
        let mut scene = tables();
        for node in &mut scene.nodes {
            node.parent_from_local = DAffine3::from_scale(DVec3::splat(scale)) * node.parent_from_local;
        }
        let mut view = view(DVec3::new(2.0, 3.0, 4.0) * scale, DVec3::ZERO, [41, 31], Aov::Visibility);
        view.camera.projection =
            Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear: 0.05 * scale, zfar: None };
        let light = spot(DVec3::new(1.0, 3.0, 0.5) * scale, DVec3::ZERO);
        let lit = picture(&scene, &view, &[light]);
        let inside = lit.pixels.iter().filter(|p| p[3] == 1.0);
        let (inside, dark) = (inside.clone().count(), inside.filter(|p| p[0] == 0.0).count());
        assert!(inside > 100 && dark > 5, "{scale}: {inside} {dark}");
    }
}

#[test]
fn an_empty_scene_is_black() {
    let lights = [spot(DVec3::Y, DVec3::ZERO)];
    for aov in ALL {
        let picture = picture(&Scene::default(), &oblique([5, 4], aov), &lights);
        assert_eq!(picture.pixels, [[0.0; 4]; 20]);
    }
}

/// Returns the error of rendering `view` under `lights`.
fn refused(view: &View, lights: &[Light]) -> RenderError {
    let mut renderer = renderer(&tables());
    let error = renderer.render(view, &instances(lights)).expect_err("this view has no picture");
    // The renderer still works.
    let good = oblique([5, 4], Aov::Depth);
    assert!(renderer.render(&good, &[]).unwrap().pixels.iter().any(|p| p[3] == 1.0));
    error
}

#[test]
fn impossible_views_are_refused_with_a_sentence() {
    let good = oblique([5, 4], Aov::Beauty);
    let with = |change: fn(&mut View)| {
        let mut view = good.clone();
        change(&mut view);
        refused(&view, &[])
    };
    let perspective = |yfov, znear, zfar| Projection::Perspective { yfov, aspect_ratio: None, znear, zfar };
    let projections = [
        perspective(4.0, 0.1, None),
        perspective(1.0, 0.0, None),
        perspective(1.0, 1.0, Some(1.0)),
        Projection::Orthographic { ymag: 0.0, aspect_ratio: None, znear: 0.0, zfar: 1.0 },
    ];
    let projections = projections.map(|projection| {
        let camera = Camera { projection, ..good.camera.clone() };
        refused(&View { camera, ..good.clone() }, &[])
    });
    let numbers = [
        with(|v| v.width = 0),
        with(|v| v.samples = 0),
        with(|v| v.camera.translation.x = f64::NAN),
        with(|v| v.camera.translation.x = 1e60),
    ];
    for error in numbers.into_iter().chain(projections) {
        assert!(matches!(error, RenderError::InvalidView(_)), "{error}");
    }
    assert!(matches!(with(|v| v.height = 1_000_000), RenderError::TooLarge { .. }));
    assert_eq!(with(|v| v.aov = Aov::T), RenderError::NoSuchLight { index: 0, count: 0 });
    assert!("depht".parse::<Aov>().unwrap_err().to_string().contains("beauty, depth"));
    assert!(ALL.iter().all(|aov| aov.name().parse() == Ok(*aov)));
}

/// A light with invalid numbers never gets to a renderer; an AOV of a light out of reach is an error.
#[test]
fn impossible_lights_are_refused() {
    let good = oblique([5, 4], Aov::Beauty);
    let nan = Light::spot().with(INTENSITY, f64::NAN);
    assert_eq!(CheckedLight::new(nan).expect_err("refused"), LightError::NotFinite("intensity"));
    let far = spot(DVec3::new(1e200, 0.0, 0.0), DVec3::ZERO);
    assert!(matches!(refused(&View { aov: Aov::T, ..good }, &[far]), RenderError::OutOfReach(_)));
}

/// A light out of reach is left out, and the other lights still count.
#[test]
fn lights_out_of_reach_are_left_out() {
    let near = spot(DVec3::new(1.0, 3.0, 0.5), DVec3::ZERO);
    let ranged = spot(DVec3::Y * 3.0, DVec3::ZERO).with(RANGE, Some(6.0));
    let bent = || light::bend(&ranged, 2).unwrap();
    let checked = |light: &Light| CheckedLight::new(light.clone()).expect("a light");
    let far = [
        spot(DVec3::new(1e200, 0.0, 0.0), DVec3::ZERO),
        spot(DVec3::new(1.1e15, 0.0, 0.0), DVec3::ZERO),
        bent().with(TRANSLATION, DVec3::splat(3.4e38)),
        bent().with(SCALE, 1e30),
        bent().with(SCALE, 1e-30),
    ];
    let view = oblique([41, 31], Aov::Beauty);
    let alone = picture(&tables(), &view, std::slice::from_ref(&near));
    for light in far {
        assert_eq!(SceneBounds::from(&tables()).undrawable_of([&checked(&light)]).len(), 1, "{light:?}");
        assert_eq!(picture(&tables(), &view, &[light, near.clone()]), alone);
    }
    // Deliberate fault that the check must detect: the near one left out as well.
    assert_ne!(picture(&tables(), &view, &[]), alone);
    // Just within reach everything is finite.
    let edge = [
        spot(DVec3::new(0.9e15, 0.0, 0.0), DVec3::ZERO).with(INTENSITY, 1e300),
        bent().with(TRANSLATION, DVec3::new(0.0, 0.9e15, 0.0)),
        bent().with(SCALE, 1e13),
        bent().with(SCALE, 1e-13),
        bent().map_points(|_, point| point.intensity = 3.4e38),
    ];
    for light in edge {
        assert_eq!(SceneBounds::from(&tables()).check(&checked(&light)), Ok(()), "{light:?}");
        picture(&tables(), &view, &[light]);
    }
}

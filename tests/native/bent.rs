//! BendyLights: every parameter, filter, number of segments and kind of map.

use assets::LoadedScene;
use glam::{DQuat, DVec3};
use light::parameters::{
    CONE_ANGLE, CONE_SOFTNESS, CUT_OFF, CUT_ON, DECAY, DIFFUSE, DIRECTION, END_MODE, FAR_EDGE, FRAME, LIGHT_LINK,
    NEAR_EDGE, PROFILE, PROFILE_POWER, RADIAL_FALLOFF, SHADOW_COLOR, SHADOW_ENABLE, SHADOW_LINK, SPECULAR, TRANSLATION,
};
use light::{Decay, DirectionMode, EndMode, FrameMode, Light, Links, PeriodicCurve, ProfileCurve};
use render::{ShadowFilter, ShadowSettings};
use scene::Projection;

use super::both::{
    ViewedScene, assert_same_and_visible, assert_the_same, compared, compared_from, demo, with_superellipse,
};
use crate::pictures::shared_asset;

fn through<const N: usize>(points: [[f64; 3]; N], radii: [f64; N]) -> Light {
    let points = points.map(DVec3::from_array);
    let from_source = points.iter().map(|point| *point - points[0]).collect();
    Light::bendy(from_source, radii.to_vec()).with(TRANSLATION, points[0]).map_points(|_, point| point.intensity = 4.0)
}

/// The demo's light with its name.
fn key(loaded: &LoadedScene) -> Light {
    loaded.contents.lights[0].light().clone()
}

/// Variants of `light`: at least one changes each parameter that a layer or a map depends on.
fn varied(light: &Light) -> Vec<(&'static str, Light)> {
    let with = || light.clone();
    let without = |names: &[&str]| Links::new(Vec::new(), names.iter().map(ToString::to_string).collect());
    let radial = PeriodicCurve::new(vec![[10.0, 1.0], [120.0, 0.5], [250.0, 0.8]]).expect("it is sound");
    let section = |roundness: f64| with_superellipse(with(), 0.8, 0.5, roundness);
    vec![
        ("inverse square", with().with(DECAY, Decay::InverseSquare)),
        ("linear decay", with().with(DECAY, Decay::Linear)),
        ("cut", with().with(CUT_ON, Some(3.0)).with(NEAR_EDGE, 1.0).with(CUT_OFF, Some(4.5)).with(FAR_EDGE, 0.7)),
        ("hard", with().with(CONE_SOFTNESS, 0.0)),
        ("linear profile", with().with(PROFILE, ProfileCurve::Linear)),
        ("power", with().with(PROFILE, ProfileCurve::Power).with(PROFILE_POWER, 3.0)),
        ("cosine", with().with(PROFILE, ProfileCurve::Cosine).with(PROFILE_POWER, 2.0)),
        ("wide angle", with().with(CONE_ANGLE, 80.0)),
        ("rectangle", section(0.0)),
        ("rounded", section(0.4)),
        ("radial", with().with(RADIAL_FALLOFF, Some(radial))),
        ("shadow color", with().with(SHADOW_COLOR, DVec3::new(0.1, 0.2, 0.6))),
        ("no shadow", with().with(SHADOW_ENABLE, false)),
        ("scattered", with().with(SPECULAR, 0.0)),
        ("mirrored", with().with(DIFFUSE, 0.0)),
        ("path", with().with(DIRECTION, DirectionMode::Path)),
        ("up", with().with(FRAME, FrameMode::Up)),
        ("lights some", with().with(LIGHT_LINK, without(&["orange vase", "autumn leaves"]))),
        ("shadows of some", with().with(SHADOW_LINK, without(&["blue vase", "lantern"]))),
    ]
}

#[test]
fn a_bent_light_looks_the_same() {
    for (name, _) in assets::DEMO_NAMES {
        let loaded = demo(name);
        let (looked, light) = (ViewedScene::at(&loaded), key(&loaded));
        assert_the_same(name, &looked, &light);
        for (what, varied) in varied(&light) {
            // The planted fault: the parameter is ignored.
            assert_same_and_visible(&format!("{name}, {what}"), &looked, &light, &varied);
        }
        // A light that ends in the air, and its extension.
        let ended =
            through([[-1.2, 2.6, 0.6], [-1.0, 2.2, 0.5], [-0.6, 1.8, 0.35], [-0.1, 1.4, 0.2]], [0.1, 0.25, 0.4, 0.55]);
        let extended = ended.clone().with(END_MODE, EndMode::Extend);
        assert_same_and_visible(&format!("{name}, extended"), &looked, &ended, &extended);
        // The planted fault: a light 0.05 units to one side.
        let aside = light.clone().with(TRANSLATION, light.get(TRANSLATION) + DVec3::X * 0.05);
        let found = compared(&looked, &light, &aside);
        assert!(found.fault().is_some(), "{name} with the light aside: {found:?}");
    }
}

#[test]
fn shadows_are_filtered_alike() {
    let loaded = demo("vases");
    let light = key(&loaded);
    for filter in ShadowFilter::ALL {
        for resolution in [64, 300, 512, 2048] {
            let shadows = ShadowSettings { filter, resolution, ..ShadowSettings::default() };
            let looked = ViewedScene { shadows, ..ViewedScene::at(&loaded) };
            assert_the_same(&format!("{filter:?} {resolution}"), &looked, &light);
        }
    }
}

/// Lights of one to eight segments, and one so wide that its map has five faces.
#[test]
fn any_number_of_segments_looks_the_same() {
    let loaded = demo("vases");
    let looked = ViewedScene::at(&loaded);
    let spot = light::straighten(&key(&loaded)).expect("the demo's light can be");
    for segments in [1, 2, 4, 6, 8] {
        let light = light::bend_with_length(&spot, segments, 6.0).expect("it can be bent");
        let bowed = light.map_points(|index, point| {
            point.position.x += 0.1 * (index * (segments + 1 - index)) as f64 / 4.0;
        });
        assert_the_same(&format!("{segments} segments"), &looked, &bowed);
    }
    let wide = through([[0.0, 1.6, 0.3], [0.0, 1.2, 0.3], [0.1, 0.4, 0.3], [0.1, -0.6, 0.3]], [0.05, 1.0, 3.0, 6.0]);
    assert_the_same("wide", &looked, &wide);
}

/// Planted fault: a camera that is turned by half a pixel.
#[test]
fn surfaces_that_lie_elsewhere_are_seen() {
    let loaded = demo("vases");
    let (looked, light) = (ViewedScene::at(&loaded), key(&loaded));
    let mut turned = looked.view.clone();
    let Projection::Perspective { yfov, .. } = turned.camera.projection else { panic!("the demo has perspective") };
    turned.camera.rotation *= DQuat::from_rotation_y(0.5 * yfov / f64::from(looked.view.height));
    let compared = compared_from(&looked, &turned, &light, &light);
    assert!(compared.fault().is_some(), "{compared:?}");
}

#[test]
#[ignore = "needs ../shared/assets"]
fn shared_assets_look_the_same() {
    let bent = |size: f64| {
        let points = [[-2.6, 2.4, 0.9], [-1.9, 3.1, 0.8], [-0.5, 3.5, 0.4], [0.7, 2.2, 0.1], [1.0, -0.8, -0.1]];
        let points = points.map(|point| point.map(|x: f64| size * x));
        through(points, [0.25, 0.5, 0.75, 0.85, 1.5].map(|radius: f64| size * radius))
    };
    // The larger light shows as much of the wood as the others show of a room.
    for (file, size) in [("bench.glb", 1.0), ("vases_bowl.glb", 1.5), ("bedroom.glb", 1.0), ("outdoor.glb", 3.5)] {
        let loaded = assets::load(&shared_asset("scenes").join(file)).expect("the scene is sound");
        assert_the_same(file, &ViewedScene::at(&loaded), &bent(size));
    }
}

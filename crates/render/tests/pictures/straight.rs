//! A BendyLight that is still straight is drawn as the equal spotlight.

use glam::DVec3;
use light::parameters::{
    COLOR_TEMPERATURE, CONE_ANGLE, CONE_SOFTNESS, CROSS_SECTION, CUT_OFF, CUT_ON, DECAY, DECAY_START, DIFFUSE,
    ENABLE_COLOR_TEMPERATURE, EXPOSURE, FAR_EDGE, NEAR_EDGE, PROFILE, PROFILE_POWER, RADIAL_FALLOFF, RANGE,
    SECTION_ROUNDNESS, SECTION_WIDTH, SHADOW_COLOR, SHADOW_ENABLE,
};
use light::{CrossSection, Decay, Light, PeriodicCurve, ProfileCurve, bend_with_length};
use render::{Aov, PassCounts, Renderer, ShadowSettings, View};
use scene::{Material, Scene};

use crate::support::{floor, instances, oblique, renderer, scene_of, since, spot, unstraightened};

fn tables() -> Scene {
    let material = Material { double_sided: true, ..Material::default() };
    scene_of([floor(3.0, 0.0), floor(0.5, 1.0), floor(0.2, 1.6)], vec![material])
}

fn seen(aov: Aov) -> View {
    oblique([97, 71], aov)
}

/// Returns a renderer with default settings.
fn straightening() -> Renderer {
    let mut renderer = renderer(&tables());
    renderer.set_shadow_settings(ShadowSettings::default()).expect("sound");
    renderer
}

fn key() -> Light {
    spot(DVec3::new(1.0, 3.0, 0.5), DVec3::new(0.1, 0.0, -0.2))
}

/// Returns spotlights that differ in each property that a lighting pass is compiled or placed by.
fn spots() -> Vec<Light> {
    let key = key();
    let scaled = light::Transform { scale: 0.3, ..key.transform() };
    vec![
        key.clone(),
        key.clone().with_transform(scaled).with(RANGE, Some(2.8)),
        key.clone().with(CONE_ANGLE, 80.0),
        key.clone().with(CONE_SOFTNESS, 0.0).with(DECAY, Decay::None),
        key.clone().with(PROFILE, ProfileCurve::Linear).with(DECAY, Decay::Linear),
        key.clone().with(PROFILE, ProfileCurve::Power).with(PROFILE_POWER, 2.5),
        key.clone().with(PROFILE, ProfileCurve::Cosine).with(PROFILE_POWER, 8.0),
        key.clone()
            .with(CROSS_SECTION, CrossSection::Superellipse)
            .with(SECTION_WIDTH, 0.6)
            .with(SECTION_ROUNDNESS, 0.4),
        key.clone().with(CUT_ON, Some(2.0)).with(NEAR_EDGE, 0.5).with(CUT_OFF, Some(3.0)).with(FAR_EDGE, 0.4),
        key.clone().with(RADIAL_FALLOFF, PeriodicCurve::new(vec![[20.0, 1.0], [150.0, 0.4], [300.0, 0.7]])),
        key.clone().with(DECAY_START, 2.5).with(EXPOSURE, 1.0).with(DIFFUSE, 0.5),
        key.clone().with(ENABLE_COLOR_TEMPERATURE, true).with(COLOR_TEMPERATURE, 3000.0),
        key.clone().with(SHADOW_COLOR, DVec3::new(0.1, 0.2, 0.5)),
        key.with(SHADOW_ENABLE, false),
    ]
}

/// Equal to the bit, for all parameters, in every AOV that does not show the curve.
#[test]
fn a_straight_bendy_light_is_its_spotlight_to_the_bit() {
    let mut renderer = straightening();
    let mut draw =
        |light: &Light, aov| renderer.render(&seen(aov), &instances(std::slice::from_ref(light))).expect("drawn");
    for (k, spot) in spots().into_iter().enumerate() {
        let bent = bend_with_length(&spot, 3, 3.2).expect("valid");
        let aovs = [Aov::Beauty, Aov::Visibility, Aov::Vw, Aov::Direction];
        for aov in aovs.into_iter().take(if k < 3 { 4 } else { 2 }) {
            let expected = draw(&spot, aov);
            let lit = expected.pixels.iter().filter(|pixel| pixel[0] != 0.0).count();
            assert!(lit > 100, "{aov:?}: {lit} pixels of {spot:?}");
            assert!(draw(&bent, aov) == expected, "{aov:?} of {spot:?}");
        }
    }
    // Deliberate faults that the check must detect: an end that is a hundredth beside the cone, and the same light
    // drawn as a bent one.
    let bent = bend_with_length(&key(), 3, 3.2).expect("valid");
    let aside = bent.clone().map_points(|k, point| point.position.x += if k == 4 { 0.03 } else { 0.0 });
    let expected = draw(&key(), Aov::Beauty);
    assert!(draw(&aside, Aov::Beauty) != expected);
    let own = self::renderer(&tables()).render(&seen(Aov::Beauty), &instances(&[bent])).expect("drawn");
    assert!(own != expected);
}

/// Bending draws nothing. A control point that moves minimally draws its own map, and nothing once it is back.
#[test]
fn bending_draws_nothing() {
    let mut renderer = straightening();
    let bent = bend_with_length(&key(), 3, 3.2).expect("valid");
    let hair = bent.clone().map_points(|k, point| point.position.x += if k == 4 { 1e-6 } else { 0.0 });
    let mut counts = PassCounts::default();
    let mut drawn = |light: &Light| {
        renderer.render(&seen(Aov::Beauty), &instances(std::slice::from_ref(light))).expect("drawn");
        let drawn = since(std::mem::replace(&mut counts, renderer.counts()), renderer.counts());
        [drawn.gbuffer, drawn.shadow, drawn.lighting]
    };
    assert_eq!(drawn(&key()), [1, 1, 1]);
    assert_eq!(drawn(&bent), [0, 0, 0]);
    assert_eq!(drawn(&hair), [0, 1, 1]);
    assert_eq!(drawn(&bent), [0, 0, 1]);
    assert_eq!(drawn(&key()), [0, 0, 0]);
}

/// AOVs along the curve, t and the wireframe, are those of the BendyLight.
#[test]
fn aovs_along_the_curve_are_a_bendy_lights() {
    let (mut straight, mut by_itself) = (straightening(), renderer(&tables()));
    let bent = instances(&[bend_with_length(&key(), 3, 3.2).expect("valid")]);
    for aov in [Aov::T, Aov::Wireframe] {
        let drawn = straight.render(&seen(aov), &bent).expect("drawn");
        assert!(drawn == by_itself.render(&seen(aov), &bent).expect("drawn"), "{aov:?}");
    }
    let t = straight.render(&seen(Aov::T), &bent).expect("drawn");
    let most = t.pixels.iter().map(|pixel| pixel[0]).fold(0.0, f32::max);
    assert!(most > 2.5, "t goes on to {most}");
    // Deliberate fault that the check must detect: a spotlight's own t, which is 0 without a range.
    let spot = straight.render(&seen(Aov::T), &instances(&[key()])).expect("drawn");
    assert!(spot.pixels.iter().all(|pixel| pixel[0] == 0.0));
    assert_ne!(unstraightened(), ShadowSettings::default());
}

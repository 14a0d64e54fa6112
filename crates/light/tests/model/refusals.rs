//! Refused lights and their messages.

use std::ops::Bound;

use glam::{DQuat, DVec3};
use light::parameters::{
    CONE_ANGLE, CONE_SOFTNESS, INTENSITY, LIGHT_LINK, RADIAL_FALLOFF, RANGE, ROTATION, SCALE, SHADOW_LINK, TRANSLATION,
    UP,
};
use light::{
    CheckedLight, ControlPoint, Light, LightError, LightWarning, Links, MAX_KNOTS, MAX_LINK_BYTES, MAX_LINKS,
    ParameterKind, ParameterOwner, PeriodicCurve, Tube, Value, bend,
};

fn along_z(n: usize) -> Light {
    Light::bendy((0..n).map(|i| DVec3::new(0.0, 0.0, -(i as f64))).collect(), vec![0.1; n])
}

fn points(light: &mut Light) -> &mut [ControlPoint] {
    light.points_mut().expect("a BendyLight")
}

fn refusal(change: impl FnOnce(&mut Light)) -> LightError {
    let mut light = along_z(4);
    change(&mut light);
    Tube::new(&light).expect_err("refused")
}

#[test]
fn invalid_shapes_are_refused() {
    assert_eq!(Tube::new(&along_z(2)).expect_err("refused"), LightError::TooFewPoints(2));
    assert!(matches!(Tube::new(&along_z(300)), Err(LightError::TooManyPoints { count: 300, .. })));
    assert_eq!(refusal(|l| points(l)[1].radius = -0.1), LightError::Radius { index: 1, value: -0.1 });
    assert_eq!(refusal(|l| points(l)[2].radius = 1e308), LightError::Radius { index: 2, value: 1e308 });
    assert_eq!(refusal(|l| points(l)[1].position.x = f64::NAN), LightError::NotFinite("points"));
    assert_eq!(refusal(|l| l.set(TRANSLATION.to(DVec3::INFINITY))), LightError::NotFinite("transform.translation"));
    assert_eq!(refusal(|l| points(l)[0].position.x = 0.5), LightError::SourceNotAtOrigin);
    assert!(matches!(refusal(|l| l.set(UP.to(DVec3::ZERO))), LightError::OutOfDomain { field: "up", .. }));
    assert!(matches!(refusal(|l| l.set(CONE_ANGLE.to(90.0))), LightError::OutOfDomain { field: "coneAngle", .. }));
    assert!(matches!(refusal(|l| l.set(SCALE.to(0.0))), LightError::OutOfDomain { .. }));
    let too_large = |light: LightError| match light {
        LightError::OutOfDomain { field, value, .. } => (field, value),
        other => panic!("{other}"),
    };
    // The light is three units long.
    assert_eq!(too_large(refusal(|l| l.set(SCALE.to(1e308)))), ("transform.scale", 1e308));
    assert_eq!(too_large(refusal(|l| points(l)[3].position.z = -1e308)), ("points", f64::INFINITY));
    let all_equal = refusal(|l| points(l).fill(ControlPoint::new(DVec3::ZERO, 0.1)));
    assert!(matches!(all_equal, LightError::Degenerate { segment: 0, .. }));
    let doubled = refusal(|l| points(l)[2].position = DVec3::new(0.0, 0.0, 1.0));
    assert!(matches!(doubled, LightError::Degenerate { .. }), "{doubled}");
}

/// `R kappa` is exact: a quarter turn of a parabola has its largest curvature in the middle, and one per mille of
/// radius decides.
#[test]
fn folds_are_refused_at_one() {
    let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0)];
    // d0 = (0,0,-1), d1 = (1,0,0): kappa = 1 / (2 |d|^3), |d|^2 = 1/2 at u = 1/2.
    let radius = 2.0 * 0.5_f64.powf(1.5);
    let tube = |factor: f64| Tube::new(&Light::bendy(points.clone(), vec![radius * factor; 3]));
    let r_kappa = tube(0.999).expect("valid").r_kappa_max()[0];
    assert!((r_kappa - 0.999).abs() < 1e-12);
    assert!(matches!(tube(1.001), Err(LightError::Fold { segment: 0, point: 1, .. })));
}

#[test]
fn invalid_spotlights_are_refused() {
    let spot = |change: fn(&mut Light)| {
        let mut spot = Light::spot();
        change(&mut spot);
        CheckedLight::new(spot).map(drop)
    };
    assert_eq!(spot(|_| ()), Ok(()));
    assert_eq!(spot(|s| s.set(INTENSITY.to(f64::NAN))), Err(LightError::NotFinite("intensity")));
    assert!(spot(|s| s.set(RANGE.to(Some(0.0)))).is_err());
    assert!(matches!(bend(&Light::spot(), 0), Err(LightError::SegmentCount { count: 0, .. })));
}

/// Rules: LINK-4
#[test]
fn links_have_limits() {
    let checked = |links| Light::spot().with(SHADOW_LINK, links);
    let many = |count: usize| (0..count).map(|node| node.to_string()).collect::<Vec<_>>();
    let half = MAX_LINKS / 2;
    assert!(CheckedLight::new(checked(Links::new(many(half), many(half)))).is_ok());
    let limit = MAX_LINKS;
    assert_eq!(
        CheckedLight::new(checked(Links::new(many(half), many(half + 1)))).unwrap_err(),
        LightError::TooManyLinks { field: "shadowLink", count: MAX_LINKS + 1, limit }
    );
    let long = |bytes: usize| Links::new(vec!["a".repeat(bytes - 1)], vec!["b".into()]);
    assert!(CheckedLight::new(checked(long(MAX_LINK_BYTES))).is_ok());
    assert_eq!(
        CheckedLight::new(checked(long(MAX_LINK_BYTES + 1))).unwrap_err(),
        LightError::TooLong { field: "shadowLink", limit: MAX_LINK_BYTES }
    );
    let mut text = Light::spot();
    text.set(light::Setting { parameter: LIGHT_LINK.row(), value: Value::Text("vase".into()) });
    assert!(matches!(CheckedLight::new(text), Err(LightError::WrongType { field: "lightLink", .. })));
}

/// Rules: CURVE-1
#[test]
fn periodic_curves_are_in_order_and_in_range() {
    let refusal = |knots: Vec<[f64; 2]>| {
        let curve = PeriodicCurve::new(knots);
        CheckedLight::new(Light::spot().with(RADIAL_FALLOFF, curve)).expect_err("refused").to_string()
    };
    let order = "`radialFalloff` must be pairs [degrees, number] whose degrees ascend from 0 to less than 360, each given \
                 once: sort them";
    for knots in [
        vec![[10.0, 1.0], [5.0, 1.0]],
        vec![[10.0, 1.0], [10.0, 0.5]],
        vec![[-1.0, 1.0]],
        vec![[0.0, 1.0], [360.0, 1.0]],
        vec![[f64::NAN, 1.0]],
    ] {
        assert_eq!(refusal(knots.clone()), order, "{knots:?}");
    }
    let range = "`radialFalloff` is 1.5, but it must lie from 0.001 to 1: change it";
    assert_eq!(refusal(vec![[0.0, 1.0], [90.0, 1.5]]), range);
    assert_eq!(refusal(vec![[0.0, f64::NAN]]), "`radialFalloff` holds a number that is not finite: replace it");
    let many = (0..=MAX_KNOTS).map(|k| [k as f64, 1.0]).collect();
    assert_eq!(refusal(many), "`radialFalloff` has 17 pairs, at most 16 may be: leave some out");
}

/// A curl that comes back through its own light is usable, with a warning.
#[test]
fn overlaps_are_reported() {
    let ring = |turn: f64, drop: f64| {
        let at = |k: i32| {
            let angle = f64::from(k) * turn;
            DVec3::new(angle.sin(), drop * f64::from(k), angle.cos() - 1.0)
        };
        Tube::new(&Light::bendy((0..8).map(at).collect(), vec![0.3; 8])).expect("valid")
    };
    assert!(matches!(ring(1.0, 0.0).warnings()[..], [LightWarning::Overlap { .. }]));
    assert_eq!(ring(1.0, 0.3).warnings(), [], "a helix passes beside itself");
    assert_eq!(Tube::new(&along_z(5)).expect("valid").warnings(), []);
}

/// Two coincident control points make a corner. The light stays usable, and its frame continues by the smallest
/// rotation.
#[test]
fn corner_of_coincident_points() {
    let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0)];
    let tube = Tube::new(&Light::bendy(points, vec![0.1; 4])).expect("valid");
    let (v_hat, _) = tube.cross_section(&tube.segments[1].curve, tube.segments[1].curve.u_hat(0.0));
    assert!((v_hat.length() - 1.0).abs() < 1e-14);
    // On the inside of the corner both legs of the tube contain the same points.
    let warnings = tube.warnings();
    assert!(matches!(warnings[..], [LightWarning::Corner { t: 1.0 }, LightWarning::Overlap { .. }]), "{warnings:?}");
    assert!(tube.locate(DVec3::new(0.5, 0.01, -1.0)).point.is_some());
}

/// Rows bound the values, and the message has the range.
#[test]
fn every_parameter_refuses_values_outside_its_range() {
    let sentence = |light: Light| CheckedLight::new(light).expect_err("refused").to_string();
    assert_eq!(
        sentence(Light::spot().with(CONE_ANGLE, 90.0)),
        "`coneAngle` is 90, but it must be more than 0 and less than 90 degrees: change it"
    );
    assert_eq!(
        sentence(along_z(4).with(CONE_SOFTNESS, 1.5)),
        "`coneSoftness` is 1.5, but it must lie from 0 to 1: change it"
    );
    assert_eq!(sentence(along_z(4).with(SCALE, 0.0)), "`transform.scale` is 0, but it must be more than 0: change it");
    let turned = Light::spot().with(ROTATION, DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0));
    assert!(sentence(turned).starts_with("`transform.rotation` has length 0, but it must be a unit quaternion"));
    for row in [ParameterOwner::Spot, ParameterOwner::Bendy, ParameterOwner::Omni, ParameterOwner::Directional]
        .into_iter()
        .flat_map(light::parameters_of)
    {
        assert!(!row.label.is_empty() && row.doc.ends_with('.') && !row.group.is_empty(), "{row:?}");
        for of in row.owners {
            let default = row.default(of.owner).expect("a light's parameter has a default");
            assert_eq!(row.check(&default), Ok(()), "{}", row.name);
        }
        let ParameterKind::Number(number) = row.kind else { continue };
        for (bound, beyond) in [(number.min, -1e-9), (number.max, 1e-9)] {
            let (Bound::Included(end) | Bound::Excluded(end)) = bound else { continue };
            let value = end + beyond * end.abs().max(1.0);
            let refused = row.check(&Value::Number(value)).expect_err("out of range").to_string();
            assert!(refused.contains(row.path) && refused.contains(&end.to_string()), "{refused}");
        }
        assert_eq!(row.check(&Value::Number(f64::NAN)), Err(LightError::NotFinite(row.path)));
    }
}

//! What is refused, and that it says why.

use glam::DVec3;
use light::{BendyLight, LightError, LightWarning, SpotLight, Tube, bend, check_spot};

fn along_z(n: usize) -> BendyLight {
    BendyLight::new((0..n).map(|i| DVec3::new(0.0, 0.0, -(i as f64))).collect(), vec![0.1; n])
}

fn refusal(change: impl FnOnce(&mut BendyLight)) -> LightError {
    let mut light = along_z(4);
    change(&mut light);
    Tube::new(&light).expect_err("refused")
}

#[test]
fn shapes_that_cannot_be() {
    assert_eq!(Tube::new(&along_z(2)).expect_err("refused"), LightError::TooFewPoints(2));
    assert!(matches!(Tube::new(&along_z(300)), Err(LightError::TooManyPoints { count: 300, .. })));
    assert!(matches!(refusal(|l| l.radii.truncate(2)), LightError::LengthMismatch { field: "radii", .. }));
    assert_eq!(refusal(|l| l.radii[1] = -0.1), LightError::Radius { index: 1, value: -0.1 });
    assert_eq!(refusal(|l| l.radii[2] = 1e308), LightError::Radius { index: 2, value: 1e308 });
    assert_eq!(refusal(|l| l.points[1].x = f64::NAN), LightError::NotFinite("points"));
    assert_eq!(refusal(|l| l.transform.translation.x = f64::INFINITY), LightError::NotFinite("transform"));
    assert_eq!(refusal(|l| l.points[0].x = 0.5), LightError::SourceNotAtOrigin);
    assert!(matches!(refusal(|l| l.up = DVec3::ZERO), LightError::OutOfDomain { field: "up", .. }));
    assert!(matches!(refusal(|l| l.cone_angle = 90.0), LightError::OutOfDomain { field: "coneAngle", .. }));
    assert!(matches!(refusal(|l| l.transform.scale = 0.0), LightError::OutOfDomain { .. }));
    let all_equal = refusal(|l| l.points = vec![DVec3::ZERO; 4]);
    assert!(matches!(all_equal, LightError::Degenerate { segment: 0, .. }));
    let doubled = refusal(|l| l.points[2] = DVec3::new(0.0, 0.0, 1.0));
    assert!(matches!(doubled, LightError::Degenerate { .. }), "{doubled}");
}

/// `R kappa` is exact: a quarter turn of a parabola has its largest curvature in the middle, and one per
/// mille of radius more or less decides.
#[test]
fn folds_are_refused_at_one() {
    let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0)];
    // d0 = (0,0,-1), d1 = (1,0,0): kappa = 1 / (2 |d|^3), |d|^2 = 1/2 at u = 1/2.
    let radius = 2.0 * 0.5_f64.powf(1.5);
    let tube = |factor: f64| Tube::new(&BendyLight::new(points.clone(), vec![radius * factor; 3]));
    let r_kappa = tube(0.999).expect("valid").r_kappa_max()[0];
    assert!((r_kappa - 0.999).abs() < 1e-12);
    assert!(matches!(tube(1.001), Err(LightError::Fold { segment: 0, point: 1, .. })));
}

#[test]
fn spotlights() {
    let spot = |change: fn(&mut SpotLight)| {
        let mut spot = SpotLight::default();
        change(&mut spot);
        check_spot(&spot)
    };
    assert_eq!(spot(|_| ()), Ok(()));
    assert_eq!(spot(|s| s.intensity = f64::NAN), Err(LightError::NotFinite("intensity")));
    assert!(spot(|s| s.range = Some(0.0)).is_err());
    assert_eq!(bend(&SpotLight::default(), 0), Err(LightError::SegmentCount(0)));
}

/// A curl that comes back through its own light is usable, and said.
#[test]
fn overlaps_are_reported() {
    let ring = |turn: f64, drop: f64| {
        let at = |k: i32| {
            let angle = f64::from(k) * turn;
            DVec3::new(angle.sin(), drop * f64::from(k), angle.cos() - 1.0)
        };
        Tube::new(&BendyLight::new((0..8).map(at).collect(), vec![0.3; 8])).expect("valid")
    };
    assert!(matches!(ring(1.0, 0.0).warnings()[..], [LightWarning::Overlap { .. }]));
    assert_eq!(ring(1.0, 0.3).warnings(), [], "a helix passes beside itself");
    assert_eq!(Tube::new(&along_z(5)).expect("valid").warnings(), []);
}

/// Two control points in one place make a corner; the light stays usable and its frame goes on by the
/// smallest rotation.
#[test]
fn corner_of_coincident_points() {
    let points =
        vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -1.0)];
    let tube = Tube::new(&BendyLight::new(points, vec![0.1; 4])).expect("valid");
    let (v_hat, _) = tube.cross_section(&tube.segments[1], tube.segments[1].u_hat(0.0));
    assert!((v_hat.length() - 1.0).abs() < 1e-14);
    // On the inside of the corner both legs of the tube hold the same points.
    let warnings = tube.warnings();
    assert!(
        matches!(warnings[..], [LightWarning::Corner { t: 1.0 }, LightWarning::Overlap { .. }]),
        "{warnings:?}"
    );
    assert!(tube.locate(DVec3::new(0.5, 0.01, -1.0)).point.is_some());
}

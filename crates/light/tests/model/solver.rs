//! Points back into the tube (light model, sections 3 and 5): single points. `bendylights-studies stress` tests the
//! properties of all points.

use glam::DVec3;
use light::{Light, Tube};

/// Points exactly on a joint's plane lie in the lower segment, once.
#[test]
fn joints_count_once() {
    let points = (0..5).map(|i| DVec3::new(0.0, 0.0, -f64::from(i))).collect();
    let tube = Tube::new(&Light::bendy(points, vec![0.5; 5])).expect("valid");
    let location = tube.locate(DVec3::new(0.1, 0.2, -1.5));
    assert_eq!(location.roots, [1.0]);
    assert_eq!(location.point.map(|p| (p.segment, p.u)), Some((0, 1.0)));
}

/// The radius is zero at a cone's apex. The apex is inside with v = w = 0; points close behind and beside it are not.
#[test]
fn the_apex_lies_in_the_light() {
    let points = (0..3).map(|i| DVec3::new(0.0, 0.0, -f64::from(i))).collect();
    let tube = Tube::new(&Light::bendy(points, vec![0.0, 0.5, 1.0])).expect("valid");
    let apex = tube.locate(DVec3::ZERO).point.expect("the source lies in its light");
    assert_eq!((apex.t, apex.v, apex.w, apex.direction), (0.0, 0.0, 0.0, DVec3::Z));
    assert_eq!(tube.locate(DVec3::new(1e-9, 0.0, 0.0)).point, None);
    assert_eq!(tube.locate(DVec3::new(0.0, 0.0, 1e-9)).point, None);
}

/// `P'` is zero where control points coincide, and a point's root lies close to a sign change of `f'`. Points of the
/// curve are found to the position that f32 resolves.
#[test]
fn near_a_cusp() {
    let along = DVec3::new(0.0, 0.31, -1.02);
    let tube = Tube::new(&Light::bendy(vec![DVec3::ZERO, along, along], vec![0.005; 3])).expect("valid");
    let single = Tube::<f32>::from(&tube);
    for k in 1..200 {
        let u = 1.0 - f64::from(k) * 1e-3;
        let q = tube.segments[0].curve.position(u);
        let (exact, rounded) = (tube.nearest_root(q), single.nearest_root(q.as_vec3()));
        // P'(u) = 2 d1' (1 - u): a position error of 16 eps of the light's length, 2 d0 here, is this error in u.
        let bound = |eps: f64| 16.0 * eps / (1.0 - u);
        assert!((exact.expect("on the curve").u - u).abs() < bound(f64::EPSILON), "{u}");
        let off = (f64::from(rounded.expect("on the curve").u) - u).abs();
        assert!(off < bound(f64::from(f32::EPSILON) / 2.0), "{u}: off by {off}");
    }
}

//! Bent paths: chords that stay within their bound, and hits that a slow march finds too.

use glam::{DAffine3, DQuat, DVec3};
use light::parameters::{DIRECTION, END_MODE, FRAME, RANGE, ROTATION};
use light::{DirectionMode, EndMode, FrameMode, Light, Transform, Tube};
use proptest::prelude::*;
use raycast::{Aabb64, BentHit, BentPath, Bvh};

use crate::bvh_of;

/// Prepares a scene of separate triangles.
fn bvh_of_triangles(triangles: &[[DVec3; 3]], world_from_local: DAffine3) -> Bvh {
    let positions: Vec<_> = triangles.iter().flatten().map(|corner| corner.as_vec3()).collect();
    let indices = (0..positions.len() as u32).collect();
    bvh_of(positions, indices, world_from_local)
}

/// Makes a path in a scene space whose origin is that of the world.
fn path_in_world(tube: &Tube<f64>, (v, w): (f64, f64)) -> BentPath<'_> {
    BentPath::new(tube, v, w, DVec3::ZERO)
}

/// Returns the position at `t` on a path.
fn position_at(path: &BentPath, t: f64) -> DVec3 {
    let segment = (t as usize).min(path.tube.segments.len() - 1);
    path.position_at(segment, t - segment as f64)
}

fn vector(size: f64) -> impl Strategy<Value = DVec3> {
    [-size..size, -size..size, -size..size].prop_map(DVec3::from)
}

/// Generates tubes of two to four segments, from gentle bends to hairpins, in both frame modes and both end modes.
/// Tubes that fold over themselves are invalid and left out.
fn tubes() -> impl Strategy<Value = Tube<f64>> {
    let bends = prop::collection::vec((vector(1.2), 0.0..0.5), 2..5);
    (bends, any::<bool>(), any::<bool>()).prop_filter_map("folds", |(bends, up, extend)| {
        let mut points = vec![DVec3::ZERO, DVec3::NEG_Z];
        points.extend(bends.iter().enumerate().map(|(i, (bend, _))| DVec3::NEG_Z * (i + 2) as f64 + *bend));
        let radii = [0.02, 0.2].into_iter().chain(bends.iter().map(|(_, radius)| 0.05 + radius)).collect();
        let light = Light::bendy(points, radii)
            .with(FRAME, if up { FrameMode::Up } else { FrameMode::RotationMinimizing })
            .with(END_MODE, if extend { EndMode::Extend } else { EndMode::Cut })
            .with(DIRECTION, DirectionMode::Path);
        Tube::new(&light).ok()
    })
}

fn across() -> impl Strategy<Value = (f64, f64)> {
    (0.0..1.0_f64, 0.0..std::f64::consts::TAU).prop_map(|(rho, angle)| (rho * angle.cos(), rho * angle.sin()))
}

/// Returns the largest distance between a path and its chords at equal u, as a share of the bound.
fn worst_chord_error(tube: &Tube<f64>, vw: (f64, f64)) -> f64 {
    let path = path_in_world(tube, vw);
    let mut worst = 0.0_f64;
    path.for_each_chord(tube.n as f64, &Aabb64::INFINITE, |chord| {
        let [from, to] = chord.ends;
        for k in 1..8 {
            let share = f64::from(k) / 8.0;
            let u = chord.u[0] + (chord.u[1] - chord.u[0]) * share;
            let error = path.position_at(chord.segment, u).distance(from.lerp(to, share));
            // Rounding of points about one unit from the origin.
            worst = worst.max((error - 1e-14) / chord.error().max(1e-300));
        }
        false
    });
    worst
}

/// Returns the largest distance of a path's points from its polyline, the length of the path, measured in small steps,
/// and the error of that length.
fn polyline_errors(path: &BentPath, t_end: f64, polyline: &[DVec3]) -> (f64, f64, f64) {
    let off = |point: DVec3| {
        let pieces = polyline.windows(2).map(|piece| {
            let along = piece[1] - piece[0];
            let share = (point - piece[0]).dot(along) / along.length_squared();
            point.distance(piece[0] + along * share.clamp(0.0, 1.0))
        });
        pieces.fold(f64::INFINITY, f64::min)
    };
    let steps = 40_000;
    let points: Vec<DVec3> = (0..=steps).map(|k| position_at(path, t_end * f64::from(k) / f64::from(steps))).collect();
    let worst = points.iter().step_by(10).map(|point| off(*point)).fold(0.0, f64::max);
    let walked = |stride: usize| {
        let steps = points.windows(stride + 1).step_by(stride);
        steps.map(|step| step[0].distance(step[stride])).sum::<f64>()
    };
    // Halving the steps removes three quarters of the error, and less if the frame flips about the curve.
    let [fine, coarse] = [walked(1), walked(2)];
    (worst, (4.0 * fine - coarse) / 3.0, (fine - coarse).abs())
}

/// Tests the path as a polyline of 1,000 steps a segment against every triangle. It is slow and shares nothing with the
/// crate.
fn march(path: &BentPath, triangles: &[[DVec3; 3]], t_end: f64) -> Option<(f64, usize)> {
    let steps = (1000.0 * t_end).ceil() as usize;
    (0..steps).find_map(|k| {
        let [t0, t1] = [k, k + 1].map(|k| t_end * k as f64 / steps as f64);
        let (from, to) = (position_at(path, t0), position_at(path, t1));
        triangles.iter().enumerate().find_map(|(index, [a, b, c])| {
            let normal = (b - a).cross(c - a);
            let share = normal.dot(a - from) / normal.dot(to - from);
            let x = from.lerp(to, share);
            let inside = [[a, b], [b, c], [c, a]].iter().all(|[p, q]| (*q - *p).cross(x - *p).dot(normal) >= 0.0);
            ((0.0..=1.0).contains(&share) && inside).then_some((t0 + share * (t1 - t0), index))
        })
    })
}

fn first(tube: &Tube<f64>, (v, w): (f64, f64), triangles: &[[DVec3; 3]]) -> Option<BentHit> {
    let bvh = bvh_of_triangles(triangles, DAffine3::IDENTITY);
    let path = bvh.bent_path(tube, v, w);
    let hit = bvh.first_bent_hit(&path, tube.n as f64, |_| true);
    assert_eq!(hit.is_some(), bvh.has_bent_hit(&path, tube.n as f64, |_| true));
    hit
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn chords_stay_within_their_bound(tube in tubes(), vw in across()) {
        prop_assert!(worst_chord_error(&tube, vw) <= 1.0);
    }

    /// A polyline stays within its stated error, which is small enough unless the number of points is limited.
    #[test]
    fn polylines_stay_beside_their_path(tube in tubes(), vw in across(), share in 0.1..1.0_f64) {
        let path = path_in_world(&tube, vw);
        let t_end = share * tube.segments.len() as f64;
        let fine = path.polyline(t_end, 256);
        let (error, walked, unsure) = polyline_errors(&path, t_end, &fine.points);
        prop_assert!(error <= fine.max_error + 1e-14 && fine.points.len() <= 256);
        prop_assert!(fine.points.len() == 256 || fine.max_error <= fine.length / 4096.0);
        // If the "up" frame flips about the curve within a tiny range, steps skip the length of the flip.
        let may_flip = tube.frame == FrameMode::Up && fine.length > walked;
        prop_assert!(may_flip || (fine.length - walked).abs() < 1e-6 * walked + unsure, "{} {walked}", fine.length);
    }

    #[test]
    fn hits_are_those_of_a_slow_march(
        tube in tubes(),
        vw in across(),
        triangles in prop::collection::vec((vector(1.5), vector(1.0), vector(1.0)), 1..40),
    ) {
        // Rounded to f32 as in the scene, all along the light.
        let triangles: Vec<_> = triangles.iter().enumerate().map(|(i, (a, b, c))| {
            let middle = DVec3::NEG_Z * (i % 4) as f64 + *a;
            [middle, middle + *b, middle + *c].map(|corner| corner.as_vec3().as_dvec3())
        }).collect();
        let path = path_in_world(&tube, vw);
        let found = first(&tube, vw, &triangles);
        let walked = march(&path, &triangles, tube.n as f64);
        // The error of a polyline with steps h is |C''| h^2 / 8, here below 1e-5. Near an edge, or if path and plane
        // are nearly parallel, the two results may rightly differ.
        let agree = match (&found, &walked) {
            (Some(hit), Some((t, index))) => hit.triangle == *index && (hit.t - t).abs() < 1e-3,
            (None, None) => true,
            _ => false,
        };
        prop_assume!(agree || !is_a_near_miss(&path, &triangles, found.as_ref(), walked));
        prop_assert!(agree, "{found:?} {walked:?}");
    }
}

/// Returns true if the two first hits differ because a path passes an edge, or touches a plane, within 1e-4.
fn is_a_near_miss(
    path: &BentPath,
    triangles: &[[DVec3; 3]],
    found: Option<&BentHit>,
    walked: Option<(f64, usize)>,
) -> bool {
    let t = found.map_or(f64::INFINITY, |hit| hit.t).min(walked.map_or(f64::INFINITY, |(t, _)| t));
    let (segment, index) = match (found, walked) {
        (Some(hit), _) if hit.t == t => (t as usize, hit.triangle),
        (_, Some((_, index))) => (t as usize, index),
        _ => return false,
    };
    let segment = segment.min(path.tube.segments.len() - 1);
    let (u, h) = (t - segment as f64, 1e-4);
    let at = path.position_at(segment, u);
    let tangent = (path.position_at(segment, u + h) - path.position_at(segment, u - h)).normalize_or_zero();
    let [a, b, c] = triangles[index];
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let to_edge = |p: DVec3, q: DVec3| (at - p).cross((q - p).normalize_or_zero()).length();
    let edge = to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a));
    edge < 1e-4 || normal.dot(tangent).abs() < 1e-2
}

#[test]
fn the_bound_on_chords_is_not_slack() {
    // A quarter circle of bend. The bound would be useless at ten times the error.
    let light = Light::bendy(vec![DVec3::ZERO, DVec3::NEG_Z, DVec3::new(1.0, 0.0, -1.0)], vec![0.2; 3]);
    let tube = Tube::new(&light).unwrap();
    let worst = worst_chord_error(&tube, (0.5, 0.5));
    assert!((0.2..=1.0).contains(&worst), "{worst}");
}

/// Deliberate fault that the check must detect: a polyline with too few points has a large error and reports it.
#[test]
fn a_polyline_of_few_points_strays() {
    let points = [DVec3::ZERO, DVec3::NEG_Z, DVec3::new(1.0, 0.0, -2.0)];
    let tube = Tube::new(&Light::bendy(points.into(), vec![0.1, 0.2, 0.3])).expect("a tube");
    let path = path_in_world(&tube, (0.3, 0.4));
    let [few, many] = [3, 256].map(|most| path.polyline(1.0, most));
    let (error, ..) = polyline_errors(&path, 1.0, &few.points);
    assert!(few.points.len() == 3 && error > few.length / 4096.0 && few.max_error >= error);
    assert!((10..100).contains(&many.points.len()), "{}", many.points.len());
}

#[test]
fn a_wrong_sign_across_the_tube_is_seen() {
    let light = Light::bendy(vec![DVec3::ZERO, DVec3::NEG_Z * 2.0, DVec3::new(2.0, 1.0, -3.0)], vec![0.3; 3]);
    let tube = Tube::new(&light).unwrap();
    // A small triangle in front of one path only.
    let (v, w) = (0.3, 0.6);
    let on_path = path_in_world(&tube, (v, w)).position_at(0, 0.5);
    let triangle = [DVec3::new(-0.05, -0.05, 0.0), DVec3::new(0.05, -0.05, 0.0), DVec3::new(0.0, 0.05, 0.0)]
        .map(|corner| (on_path + corner).as_vec3().as_dvec3());
    let hit = first(&tube, (v, w), &[triangle]).expect("the triangle lies on the path");
    // The triangle is flat and rounded to f32, so t is near that of its middle.
    assert!((hit.t - 0.5).abs() < 1e-6, "{hit:?}");
    assert!(first(&tube, (v, -w), &[triangle]).is_none());
}

#[test]
fn a_straight_cone_has_straight_rays() {
    let spot = Light::spot()
        .with(RANGE, Some(4.0))
        .with_transform(Transform { translation: DVec3::new(1.0, 2.0, 3.0), ..Transform::default() });
    let tube = Tube::new(&light::bend(&spot, 3).unwrap()).unwrap();
    let wall = [DVec3::new(-9.0, -9.0, 0.5), DVec3::new(9.0, -9.0, -0.5), DVec3::new(0.0, 20.0, 0.0)];
    let bvh = bvh_of_triangles(&[wall], DAffine3::IDENTITY);
    for (v, w) in [(0.0, 0.0), (0.9, 0.1), (-0.3, -0.8)] {
        let path = bvh.bent_path(&tube, v, w);
        let bent = bvh.first_bent_hit(&path, 3.0, |_| true).unwrap();
        let away = path.position_at(2, 1.0) - path.position_at(0, 0.0);
        let straight = bvh.first_hit(path.position_at(0, 0.0), away, [0.0, 1.0], |_| true).unwrap();
        let position = path.position_at(0, 0.0) + away * straight.distance;
        // Coordinates are below 4 and the wall is nearly perpendicular to the light: a few ulps.
        assert!(bent.position.distance(position) < 1e-14, "{bent:?} {position}");
    }
}

#[test]
fn triangles_without_area_block_nothing() {
    let tube =
        Tube::new(&Light::bendy(vec![DVec3::ZERO, DVec3::NEG_Z, DVec3::NEG_Z * 2.0], vec![0.0, 0.2, 0.4])).unwrap();
    let point = DVec3::new(0.0, 0.0, -1.0);
    assert!(first(&tube, (0.0, 0.0), &[[point; 3], [point, point + DVec3::X, point - DVec3::X]]).is_none());
    assert!(first(&tube, (0.0, 0.0), &[]).is_none());
}

#[test]
fn light_past_the_end_goes_straight_on() {
    let light = Light::bendy(vec![DVec3::ZERO, DVec3::NEG_Z, DVec3::new(0.5, 0.0, -2.0)], vec![0.1, 0.2, 0.3])
        .with(END_MODE, EndMode::Extend);
    let tube = Tube::new(&light).unwrap();
    let end = DVec3::new(0.5, 0.0, -2.0) + DVec3::new(0.5, 0.0, -1.0) * 50.0;
    let turn = DQuat::from_rotation_y(0.3);
    let wall = [DVec3::new(-9.0, -9.0, 0.0), DVec3::new(9.0, -9.0, 0.0), DVec3::new(0.0, 20.0, 0.0)]
        .map(|corner| (end + turn * corner).as_vec3().as_dvec3());
    let bvh = bvh_of_triangles(&[wall], DAffine3::IDENTITY);
    let hit = bvh.first_bent_hit(&bvh.bent_path(&tube, 0.0, 0.0), 200.0, |_| true).expect("the wall stands in the way");
    // Corners of size 50 are rounded to f32: 4e-6.
    assert!((hit.position + bvh.posed.origin_in_world).distance(end) < 1e-5, "{hit:?}");
}

/// A path in a triangle's plane does not cross it, and the search ends. Rounding alone decides the side of the plane,
/// so there would be 1e8 points to test.
#[test]
fn a_path_in_a_triangles_plane_passes_it() {
    let rotation = DQuat::from_xyzw(-0.44, -0.18, 0.36, 0.8).normalize();
    let points = (0..4).map(|i| DVec3::new(0.0, 0.0, -f64::from(i))).collect();
    let light = Light::bendy(points, vec![0.3, 0.2, 0.4, 0.1]).with(ROTATION, rotation);
    let tube = Tube::new(&light).expect("valid");
    let flat = [(0.0, -1.0, -0.5), (0.0, 1.0, -0.625), (0.0, 0.25, -2.75)];
    let bvh = bvh_of_triangles(&[flat.map(DVec3::from)], DAffine3::from_quat(rotation));
    for w in [-0.9, -0.5, 0.0, 0.3, 0.8] {
        assert!(!bvh.has_bent_hit(&bvh.bent_path(&tube, 0.0, w), 3.0, |_| true), "w = {w}");
    }
}

//! Straight rays: the results of a search over every triangle, and no cracks.

use glam::{DAffine3, DVec3, Vec3};
use proptest::prelude::*;
use raycast::{Bvh, Hit};
use scene::Scene;

use crate::bvh_of;

/// Returns a bumpy sheet of `n` by `n` squares from -1 to 1 around y = 0.
fn sheet(n: u32, world_from_local: DAffine3) -> Bvh {
    let side = n + 1;
    let at = |k: u32| {
        let (x, z) = ((k % side) as f32 / n as f32 * 2.0 - 1.0, (k / side) as f32 / n as f32 * 2.0 - 1.0);
        Vec3::new(x, 0.1 * (7.0 * x).sin() * (5.0 * z).cos(), z)
    };
    let squares = (0..n * n).map(|k| k / n * side + k % n);
    let indices = squares.flat_map(|k| [k, k + side, k + 1, k + 1, k + side, k + side + 1]).collect();
    bvh_of((0..side * side).map(at).collect(), indices, world_from_local)
}

/// Finds the nearest hit by a test of every triangle.
fn search(bvh: &Bvh, origin: DVec3, direction: DVec3) -> Option<(f64, usize)> {
    let hits = bvh.triangles().enumerate().filter_map(|(index, triangle)| {
        let normal = triangle.normal();
        let distance = normal.dot(triangle.corners[0] - origin) / normal.dot(direction);
        let on = triangle.barycentrics_at(origin + direction * distance).is_some();
        (distance >= 0.0 && on).then_some((distance, index))
    });
    hits.min_by(|a, b| a.partial_cmp(b).expect("finite"))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn the_hierarchy_finds_what_a_search_finds(
        corners in prop::collection::vec(prop::array::uniform3(-3.0_f32..3.0), 3..150),
        origin in prop::array::uniform3(-5.0..5.0_f64),
        direction in prop::array::uniform3(-1.0..1.0_f64),
        far_away in prop::bool::ANY,
    ) {
        let offset = if far_away { DVec3::new(1e6, -1e6, 5e5) } else { DVec3::ZERO };
        let count = corners.len() as u32 / 3 * 3;
        let positions = corners.into_iter().map(Vec3::from).collect();
        let bvh = bvh_of(positions, (0..count).collect(), DAffine3::from_translation(offset));
        let (origin, direction) = (DVec3::from(origin) + offset - bvh.posed.origin_in_world, DVec3::from(direction));
        prop_assume!(direction.length() > 0.1);
        let hit = bvh.first_hit(origin, direction, [0.0, f64::INFINITY], |_| true);
        prop_assert_eq!(hit.map(|hit| (hit.distance, hit.triangle)), search(&bvh, origin, direction));
    }
}

#[test]
fn no_ray_slips_between_neighbours() {
    // Rays aim at every vertex and every edge's middle of a sheet that is rotated, scaled and far away.
    let transform =
        DAffine3::from_rotation_y(0.7) * DAffine3::from_rotation_x(0.3) * DAffine3::from_scale(DVec3::splat(3.3));
    for offset in [DVec3::ZERO, DVec3::new(1e6, 2e6, -3e6)] {
        let bvh = sheet(24, DAffine3::from_translation(offset) * transform);
        let eye = offset - bvh.posed.origin_in_world + transform.transform_point3(DVec3::new(0.1, 3.0, 0.2));
        let inner = |corner: DVec3| {
            let local = transform.inverse().transform_point3(corner + bvh.posed.origin_in_world - offset);
            local.x.abs() < 0.99 && local.z.abs() < 0.99
        };
        let mut aimed = 0;
        for triangle in bvh.triangles() {
            for k in 0..3 {
                let (a, b) = (triangle.corners[k], triangle.corners[(k + 1) % 3]);
                for target in [a, (a + b) / 2.0].into_iter().filter(|target| inner(*target)) {
                    aimed += 1;
                    let hit = bvh.first_hit(eye, target - eye, [0.0, 2.0], |_| true);
                    assert!(hit.is_some(), "a ray at {target} slips through");
                }
            }
        }
        assert!(aimed > 3000);
    }
}

#[test]
fn a_ray_keeps_to_its_range_and_to_what_is_accepted() {
    let bvh = sheet(1, DAffine3::IDENTITY);
    let ask = |range, accept: fn(&Hit) -> bool| {
        bvh.first_hit(DVec3::new(0.2, 3.0, 0.3), DVec3::NEG_Y, range, accept).map(|hit| hit.triangle)
    };
    let there = ask([0.0, f64::INFINITY], |_| true);
    assert!(there.is_some());
    assert_eq!(ask([0.0, 2.5], |_| true), None);
    assert_eq!(ask([3.5, 9.0], |_| true), None);
    assert_eq!(ask([0.0, 9.0], |_| false), None);
    let nothing = Bvh::new(scene::pose(Scene::default(), 0.0));
    assert!(nothing.first_hit(DVec3::ZERO, DVec3::X, [0.0, f64::INFINITY], |_| true).is_none());
}

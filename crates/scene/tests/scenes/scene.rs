//! Poses, the framing camera, and errors of `Scene::check`.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

use glam::{DAffine3, DVec3, Vec2, Vec3};
use light::SceneBounds;
use scene::{Material, Mesh, Node, Primitive, Projection, Scene, framing_camera, pose, world_bounds};

fn node(parent: Option<usize>, parent_from_local: DAffine3, mesh: Option<usize>) -> Node {
    Node { name: String::new(), parent, parent_from_local, mesh }
}

/// Returns a scene of one triangle. Its node lies under a moved and a scaled node.
fn nested() -> Scene {
    let primitive = Primitive {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(0.0, 2.0, 1.0)],
        normals: vec![Vec3::Z; 3],
        indices: vec![0, 1, 2],
        ..Primitive::default()
    };
    let moved = DAffine3::from_translation(DVec3::new(10.0, 0.0, 0.0));
    Scene {
        nodes: vec![
            node(None, moved, None),
            node(Some(0), DAffine3::from_scale(DVec3::splat(2.0)), None),
            node(Some(1), moved, Some(0)),
        ],
        meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
        materials: vec![Material::default()],
        ..Scene::default()
    }
}

#[test]
fn placements_are_composed_from_the_root() {
    let scene = nested();
    let posed = pose(scene.clone(), 0.0);
    let [primitive] = posed.primitives[..] else { panic!("one node has a mesh") };
    assert_eq!((primitive.node, primitive.mesh_and_primitive), (2, [0, 0]));
    // 10 + 2 (10 + 1): the outermost transform applies last.
    assert_eq!(primitive.world_from_local.transform_point3(DVec3::X), DVec3::new(32.0, 0.0, 0.0));
    // The origin of scene space is the centre of the bounds.
    assert_eq!(posed.origin_in_world, DVec3::new(31.0, 2.0, 1.0));
    assert_eq!(posed.half_extent, DVec3::new(1.0, 2.0, 1.0));
    assert_eq!(posed.positions[1], DVec3::new(1.0, -2.0, -1.0));
    assert_eq!(world_bounds(&scene), Some((DVec3::new(30.0, 0.0, 0.0), DVec3::new(32.0, 4.0, 2.0))));
    assert_eq!(world_bounds(&Scene::default()), None);
}

/// A mirroring node swaps two corners, so that triangles keep their front. Other nodes keep the order.
#[test]
fn mirrored_triangles_keep_their_front() {
    for (scale, triangle) in [(DVec3::ONE, [0, 1, 2]), (DVec3::NEG_X + DVec3::Y + DVec3::Z, [0, 2, 1])] {
        let mut scene = nested();
        scene.nodes[2].parent_from_local = DAffine3::from_scale(scale);
        let posed = pose(scene, 0.0);
        let primitive = &posed.primitives[0];
        assert_eq!(posed.triangles(primitive).collect::<Vec<_>>(), [triangle]);
        let [a, b, c] = triangle.map(|vertex| posed.positions[primitive.first_vertex + vertex as usize]);
        let front = primitive.normal_matrix() * DVec3::new(0.0, -1.0, 2.0);
        assert!((b - a).cross(c - a).dot(front) > 0.0);
    }
}

/// Every corner of the bounds is in the picture, wide or tall, and behind the near plane.
#[test]
fn the_framing_camera_sees_the_whole_scene() {
    let scene = nested();
    let (min, max) = world_bounds(&scene).expect("it has a triangle");
    for aspect in [0.25, 1.0, 686.0 / 382.0, 4.0] {
        let camera = framing_camera(&SceneBounds::from(&scene), aspect);
        let Projection::Perspective { yfov, aspect_ratio: None, znear, .. } = camera.projection else {
            panic!("perspective")
        };
        let camera_from_world = camera.world_from_camera().inverse();
        let half = (yfov / 2.0).tan();
        for k in 0..8 {
            let pick = |bit: i32, low: f64, high: f64| if k >> bit & 1 == 1 { high } else { low };
            let corner = DVec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z));
            let p = camera_from_world.transform_point3(corner);
            assert!(-p.z > znear, "{aspect}: {p} is before the near plane");
            assert!(p.x.abs() <= -p.z * half * aspect && p.y.abs() <= -p.z * half, "{aspect}: {p} is outside");
        }
    }
}

/// Returns a horizontal square of side `side` at `height`.
fn square(side: f32, height: f32) -> Primitive {
    let half = side / 2.0;
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    Primitive {
        positions: corners.map(|[x, z]| Vec3::new(x, height, z)).to_vec(),
        normals: vec![Vec3::Y; 4],
        indices: vec![0, 2, 1, 0, 3, 2],
        ..Primitive::default()
    }
}

/// A model on a floor three times as wide is framed without the floor. A floor alone is framed, and so is a table top.
#[test]
fn models_are_framed_without_their_floor() {
    let framed = |primitives: &[Primitive]| {
        let mut scene = nested();
        scene.nodes = vec![node(None, DAffine3::from_translation(DVec3::new(5.0, 1.0, 0.0)), Some(0))];
        scene.meshes[0].primitives = primitives.to_vec();
        let subject = pose(scene, 0.0).subject_bounds();
        (subject.center, 2.0 * subject.half_extent)
    };
    let mut wall = square(1.0, 0.0);
    wall.positions[2..].iter_mut().for_each(|corner| corner.y = 2.0);
    let model = [wall];
    let alone = (DVec3::new(5.0, 2.0, 0.0), DVec3::new(1.0, 2.0, 1.0));
    assert_eq!(framed(&model), alone);
    let floor = square(3.0, 0.0);
    assert_eq!(framed(&[&model[..], std::slice::from_ref(&floor)].concat()), alone);
    assert_eq!(framed(&[floor]), (DVec3::new(5.0, 1.0, 0.0), DVec3::new(3.0, 0.0, 3.0)));
    // A table top is not at the bottom, so it is not a floor.
    let table = [square(3.0, 1.0), square(1.0, 0.0)];
    assert_eq!(framed(&table).1, DVec3::new(3.0, 1.0, 3.0));
}

#[test]
fn errors_name_the_broken_item() {
    assert_eq!(nested().check(), Ok(()));
    let broken = |change: fn(&mut Scene)| {
        let mut scene = nested();
        change(&mut scene);
        let error = scene.check().expect_err("broken");
        (error.what, error.index)
    };
    assert_eq!(broken(|s| s.nodes[1].parent = Some(2)), ("node", 1));
    assert_eq!(broken(|s| s.nodes[2].mesh = Some(1)), ("node", 2));
    assert_eq!(broken(|s| s.nodes[0].parent_from_local.translation.x = f64::NAN), ("node", 0));
    assert_eq!(broken(|s| s.meshes[0].primitives[0].indices[2] = 3), ("mesh", 0));
    assert_eq!(broken(|s| s.meshes[0].primitives[0].indices.truncate(2)), ("mesh", 0));
    assert_eq!(broken(|s| s.meshes[0].primitives[0].normals.truncate(2)), ("mesh", 0));
    assert_eq!(broken(|s| s.meshes[0].primitives[0].positions[0].x = f32::INFINITY), ("mesh", 0));
    assert_eq!(broken(|s| s.meshes[0].primitives[0].uvs = vec![Vec2::NAN; 3]), ("mesh", 0));
    assert_eq!(broken(|s| s.meshes[0].primitives[0].material = 1), ("mesh", 0));
}

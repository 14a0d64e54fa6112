//! Rooms made of boxes, with objects and openings, for tests of shadows.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use light::Light;
use light::parameters::{INTENSITY, ROTATION, TRANSLATION};
use scene::{Aov, Camera, Material, Mesh, Node, Primitive, Projection, Scene, View};

pub const SIZE: [u32; 2] = [240, 160];

/// Box from -1 to 1.
fn cube() -> Primitive {
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2 & 1) as f32) * 2.0 - 1.0;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut primitive = Primitive::default();
    for face in faces {
        let [a, b, c, d] = face.map(corner);
        let first = primitive.positions.len() as u32;
        primitive.positions.extend([a, b, c, d]);
        primitive.normals.extend([(b - a).cross(c - a).normalize(); 4]);
        primitive.indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    primitive
}

/// Scene of boxes, each given by half its size, its rotation about y, and its center.
pub fn boxes(parts: &[([f64; 3], f64, [f64; 3])]) -> Scene {
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    for (half, turn, middle) in parts {
        let turned = DQuat::from_rotation_y(*turn);
        let placed = DAffine3::from_scale_rotation_translation((*half).into(), turned, (*middle).into());
        add_mesh(&mut scene, placed, vec![cube()]);
    }
    scene.check().expect("sound");
    scene
}

/// Adds a node with a mesh of its own.
pub fn add_mesh(scene: &mut Scene, parent_from_local: DAffine3, primitives: Vec<Primitive>) {
    let mesh = Some(scene.meshes.len());
    scene.meshes.push(Mesh { name: String::new(), primitives });
    scene.nodes.push(Node { name: String::new(), parent: None, parent_from_local, mesh });
}

/// A floor, three walls, and posts and boards around a light at their center, as high as the light and lower.
pub fn room() -> Scene {
    boxes(&[
        ([5.0, 0.1, 5.0], 0.0, [0.0, -0.1, 0.0]),
        ([0.1, 2.0, 5.0], 0.0, [-5.0, 2.0, 0.0]),
        ([0.1, 2.0, 5.0], 0.0, [5.0, 2.0, 0.0]),
        ([5.0, 2.0, 0.1], 0.0, [0.0, 2.0, -5.0]),
        ([0.1, 1.5, 0.2], 0.4, [-2.0, 1.5, 0.3]),
        ([0.15, 1.4, 0.1], 0.9, [1.8, 1.4, -0.9]),
        ([0.4, 0.03, 0.3], 0.2, [0.4, 1.2, -0.3]),
        ([0.2, 0.9, 0.1], 0.1, [-0.3, 0.9, -2.1]),
        ([0.3, 0.2, 0.1], 1.1, [1.6, 1.3, 1.2]),
        ([0.1, 0.6, 0.1], 0.6, [-1.2, 0.6, 1.4]),
        ([0.8, 0.05, 0.1], 0.7, [-2.8, 1.4, -2.2]),
        // So close to the floor that a coarse map takes them for the floor.
        ([0.5, 0.005, 0.3], 0.3, [-0.6, 0.03, 0.7]),
        ([0.4, 0.005, 0.4], 0.8, [0.9, 0.06, 1.3]),
        ([0.3, 0.005, 0.4], 0.1, [0.8, 0.12, -0.8]),
    ])
}

/// Rotation of a camera or light that looks from `eye` to `target`, with -z forward.
pub fn looking(eye: DVec3, target: DVec3, up: DVec3) -> DQuat {
    let back = (eye - target).normalize();
    let right = up.cross(back).normalize();
    DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back))
}

/// Camera at `eye` that looks at `target`.
pub fn camera(eye: impl Into<DVec3>, target: impl Into<DVec3>, yfov: f64) -> Camera {
    let translation = eye.into();
    let rotation = looking(translation, target.into(), DVec3::Y);
    let projection = Projection::Perspective { yfov, aspect_ratio: None, znear: 0.05, zfar: None };
    Camera { name: String::new(), translation, rotation, projection }
}

/// View from `eye` to `target` of the first light's visibility.
pub fn view(eye: DVec3, target: DVec3) -> View {
    View { aov: Aov::Visibility, ..View::beauty(camera(eye, target, 0.9), SIZE) }
}

/// View of the room from above.
pub fn room_view() -> View {
    view(DVec3::new(1.2, 3.6, 4.4), DVec3::new(-0.3, 0.7, -0.8))
}

/// The light at `eye`, aimed at `target`.
pub fn aimed(light: Light, eye: DVec3, target: DVec3) -> Light {
    light.with(TRANSLATION, eye).with(ROTATION, looking(eye, target, DVec3::Y))
}

/// Directional light that shines from `from` to the origin.
pub fn sun(from: DVec3, intensity: f64) -> Light {
    Light::directional().with(ROTATION, looking(from, DVec3::ZERO, DVec3::X)).with(INTENSITY, intensity)
}

/// Omni light, rotated so that no face of its map is parallel to the room's walls.
pub fn bulb(at: DVec3, intensity: f64) -> Light {
    let turned = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.5);
    Light::omni().with(TRANSLATION, at).with(ROTATION, turned).with(INTENSITY, intensity)
}

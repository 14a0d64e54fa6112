//! Small test scenes.

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, Vec3};
use light::parameters::{INTENSITY, RANGE};
use light::{Light, LightInstance, Transform};
use reference::{Reference, ReferencePicture};
use scene::{Aov, Camera, Material, Mesh, Node, Primitive, Projection, Scene, View};

/// Returns a square from -1 to 1 in the plane y = 0, facing up.
pub fn square() -> Primitive {
    Primitive {
        positions: [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)].map(|(x, z)| Vec3::new(x, 0.0, z)).into(),
        normals: vec![Vec3::Y; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    }
}

/// Returns a sphere of radius 1 with exact normals, `n` facets from pole to pole and twice as many around.
pub fn sphere(n: u32) -> Primitive {
    let around = 2 * n;
    let at = |k: u32| {
        let (theta, phi) = (
            std::f64::consts::PI * f64::from(k / (around + 1)) / f64::from(n),
            std::f64::consts::TAU * f64::from(k % (around + 1)) / f64::from(around),
        );
        DVec3::new(theta.sin() * phi.cos(), theta.cos(), -theta.sin() * phi.sin()).as_vec3()
    };
    let positions: Vec<Vec3> = (0..(n + 1) * (around + 1)).map(at).collect();
    let quads = (0..n * around).map(|k| k / around * (around + 1) + k % around);
    let indices = quads.flat_map(|k| [k, k + around + 1, k + 1, k + 1, k + around + 1, k + around + 2]).collect();
    Primitive { normals: positions.clone(), positions, indices, ..Primitive::default() }
}

pub fn scene_of(parts: impl IntoIterator<Item = (Primitive, DAffine3)>) -> Scene {
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    (scene.fill.sky, scene.fill.ground) = (DVec3::ZERO, DVec3::ZERO);
    for (primitive, parent_from_local) in parts {
        let (name, mesh) = (String::new(), Some(scene.meshes.len()));
        scene.meshes.push(Mesh { name: name.clone(), primitives: vec![primitive] });
        scene.nodes.push(Node { name, parent: None, parent_from_local, mesh });
    }
    scene.check().expect("test scenes keep their promises");
    scene
}

pub fn floor(half: f64) -> (Primitive, DAffine3) {
    (square(), DAffine3::from_scale(DVec3::splat(half)))
}

/// Builds a ball over the middle of a floor, on which it casts a shadow.
pub fn ball_over_floor() -> Scene {
    let ball = DAffine3::from_scale_rotation_translation(DVec3::splat(0.4), DQuat::IDENTITY, DVec3::Y);
    let mut scene = scene_of([floor(3.0), (sphere(12), ball)]);
    for (node, name) in scene.nodes.iter_mut().zip(["floor", "ball"]) {
        node.name = name.into();
    }
    scene
}

/// Returns the rotation that looks from `eye` to `target` along -z.
pub fn looking(eye: DVec3, target: DVec3) -> DQuat {
    let back = (eye - target).normalize();
    let right = if back.cross(DVec3::Y).length() < 1e-9 { DVec3::X } else { DVec3::Y.cross(back).normalize() };
    DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back))
}

pub fn view(eye: DVec3, target: DVec3, aov: Aov) -> View {
    let camera = Camera {
        name: String::new(),
        translation: eye,
        rotation: looking(eye, target),
        projection: Projection::Perspective { yfov: 0.8, aspect_ratio: None, znear: 0.05, zfar: None },
    };
    View { aov, ..View::beauty(camera, [48, 32]) }
}

/// Returns the centres of the pixels of a view, in rows from the top.
pub fn centres(view: &View) -> impl Iterator<Item = DVec2> {
    let (width, count) = (view.width, view.width * view.height);
    (0..count).map(move |k| DVec2::new(f64::from(k % width) + 0.5, f64::from(k / width) + 0.5))
}

pub fn spot(source: DVec3, target: DVec3) -> Light {
    let transform = Transform { translation: source, rotation: looking(source, target), scale: 1.0 };
    Light::spot().with_transform(transform).with(INTENSITY, 10.0).with(RANGE, Some(6.0))
}

/// Returns the lights checked, and numbered from 0.
pub fn instances(lights: &[Light]) -> Vec<LightInstance> {
    LightInstance::numbered(lights.to_vec()).expect("lights")
}

pub fn render(scene: &Scene, view: &View, lights: &[Light]) -> ReferencePicture {
    let frame = Reference::new(scene::pose(scene.clone(), 0.0))
        .render(view, &instances(lights), || {})
        .expect("test pictures can be made");
    assert!(frame.pixels.iter().flatten().all(|x| x.is_finite()), "{:?} holds NaN or infinity", view.aov);
    frame
}

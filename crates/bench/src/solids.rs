//! Meshes for the scenes of benchmarks.

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3, Vec4};
use scene::{Camera, Material, Mesh, Node, Primitive, Projection, Scene};

/// Base color of the scenes.
pub(crate) const GREY: Vec4 = Vec4::new(0.7, 0.7, 0.7, 1.0);

/// A mesh and its placement.
pub(crate) struct PlacedPrimitive(pub Primitive, pub DAffine3);

/// Makes a scene of meshes of one material.
pub(crate) fn scene_of(material: Material, parts: impl IntoIterator<Item = PlacedPrimitive>) -> Scene {
    let mut scene = Scene { materials: vec![material], ..Scene::default() };
    for (mesh, PlacedPrimitive(primitive, parent_from_local)) in parts.into_iter().enumerate() {
        scene.meshes.push(Mesh { name: String::new(), primitives: vec![primitive] });
        scene.nodes.push(Node { name: String::new(), parent: None, parent_from_local, mesh: Some(mesh) });
    }
    scene
}

/// Returns the camera that looks from a world position to another.
pub(crate) fn camera(eye: DVec3, target: DVec3, yfov: f64, znear: f64) -> Camera {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    Camera {
        name: String::new(),
        translation: eye,
        rotation: DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)),
        projection: Projection::Perspective { yfov, aspect_ratio: None, znear, zfar: None },
    }
}

/// Returns a square of two triangles that face up, from -1 to 1 in x and z.
pub(crate) fn square() -> Primitive {
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    Primitive {
        positions: corners.map(|[x, z]| Vec3::new(x, 0.0, z)).to_vec(),
        normals: vec![Vec3::Y; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    }
}

/// Returns a box from -1 to 1.
pub(crate) fn block() -> Primitive {
    let corner = |k: u32| Vec3::new((k & 1) as f32, (k >> 1 & 1) as f32, (k >> 2 & 1) as f32) * 2.0 - 1.0;
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut made = Primitive::default();
    for face in faces {
        let [a, b, c, d] = face.map(corner);
        let first = made.positions.len() as u32;
        made.positions.extend([a, b, c, d]);
        made.normals.extend([(b - a).cross(c - a).normalize(); 4]);
        made.indices.extend([0, 1, 2, 0, 2, 3].map(|k| first + k));
    }
    made
}

/// Returns a ball of radius 1, with `rings` rings from pole to pole and twice as many sectors: 4 `rings`^2 triangles.
pub(crate) fn ball(rings: u32) -> Primitive {
    let sectors = 2 * rings;
    let mut made = Primitive::default();
    for ring in 0..=rings {
        let (sin, cos) = (f64::from(ring) / f64::from(rings) * std::f64::consts::PI).sin_cos();
        for sector in 0..=sectors {
            let (z, x) = (f64::from(sector) / f64::from(sectors) * std::f64::consts::TAU).sin_cos();
            made.positions.push(DVec3::new(sin * x, cos, -sin * z).as_vec3());
        }
    }
    made.normals.clone_from(&made.positions);
    for ring in 0..rings {
        for sector in 0..sectors {
            let a = ring * (sectors + 1) + sector;
            let b = a + sectors + 1;
            made.indices.extend([a, b, a + 1, a + 1, b, b + 1]);
        }
    }
    made
}

/// Returns a closed vase with a narrow neck and smooth normals, with `rings` rings and twice as many sectors. It is 1
/// high, has a radius of at most 0.5, and stands on y = 0.
pub(crate) fn vase(rings: u32) -> Primitive {
    let mut made = ball(rings);
    // Radius as a function of the height from 0 to 1, and its derivative.
    let wave = |y: f64| 0.28 + 0.16 * (2.0 * std::f64::consts::PI * y).sin();
    let slope = |y: f64| 0.32 * std::f64::consts::PI * (2.0 * std::f64::consts::PI * y).cos();
    for (position, normal) in made.positions.iter_mut().zip(&mut made.normals) {
        let on_ball = position.as_dvec3();
        let around = DVec3::new(on_ball.x, 0.0, on_ball.z);
        // The poles are the centers of the flat ends. Each end has a tenth of the rings.
        let polar = on_ball.y.clamp(-1.0, 1.0).acos() / std::f64::consts::PI;
        let y = (1.1 - 1.2 * polar).clamp(0.0, 1.0);
        let end_share = (polar.min(1.0 - polar) * 12.0).min(1.0);
        let out = around.normalize_or_zero();
        *position = (out * (wave(y) * end_share) + DVec3::Y * y).as_vec3();
        *normal = if end_share < 1.0 { DVec3::Y * on_ball.y.signum() } else { (out - DVec3::Y * slope(y)).normalize() }
            .as_vec3();
    }
    made
}

//! Background, camera, light and nodes that the demo scenes share.

use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use document::SceneContents;
use glam::{DAffine3, DMat3, DQuat, DVec3, Vec4};
use light::parameters::{CONE_SOFTNESS, NAME, TRANSLATION};
use light::{CheckedLight, ControlPoint, Light, LightShape};
use scene::{Camera, Material, Mesh, Node, Primitive, Projection, Scene};

use crate::LoadedScene;

/// Background of a photo studio: a level floor that curves up into a wall.
pub struct Cyclorama {
    /// Half extent along x.
    pub half_width: f64,
    /// Position of the floor's front edge.
    pub front_z: f64,
    /// Position at which the floor ends and the curve begins.
    pub bend_z: f64,
    pub bend_radius: f64,
    /// Height of the wall.
    pub height: f64,
    /// Number of strips along the curve.
    pub strips: usize,
}

impl Cyclorama {
    /// Returns the surface. Floor and wall have two triangles each, because large triangles are the hard case
    /// of bent shadows.
    pub fn surface(&self) -> Primitive {
        let mut made = Primitive::default();
        let mut row = |y: f64, z: f64, normal: DVec3| {
            for x in [-self.half_width, self.half_width] {
                made.positions.push(DVec3::new(x, y, z).as_vec3());
                made.normals.push(normal.as_vec3());
            }
        };
        row(0.0, self.front_z, DVec3::Y);
        for strip in 0..=self.strips {
            let (sin, cos) = libm::sincos(FRAC_PI_2 * strip as f64 / self.strips as f64);
            let normal = DVec3::new(0.0, cos, sin);
            row(self.bend_radius * (1.0 - cos), self.bend_z - self.bend_radius * sin, normal);
        }
        row(self.height, self.bend_z - self.bend_radius, DVec3::Z);
        for i in (0..made.positions.len() as u32 - 2).step_by(2) {
            made.indices.extend([i, i + 1, i + 2, i + 1, i + 3, i + 2]);
        }
        made
    }
}

/// Returns a camera at `eye` that looks at `target`, with +Y up and a vertical angle of view in degrees.
pub fn camera(eye: DVec3, target: DVec3, yfov_degrees: f64) -> Camera {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    Camera {
        name: "camera".into(),
        translation: eye,
        rotation: DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)),
        projection: Projection::Perspective {
            yfov: yfov_degrees.to_radians(),
            aspect_ratio: None,
            znear: 0.1,
            zfar: None,
        },
    }
}

/// Returns a control point of a key light. Its position is in world space.
pub fn key_point(position: [f64; 3], radius: f64, intensity: f64) -> ControlPoint {
    ControlPoint { intensity, ..ControlPoint::new(DVec3::from_array(position), radius) }
}

/// Returns the key light with these control points. Its local space starts at the first.
pub fn key_light(color: DVec3, mut points: Vec<ControlPoint>) -> Light {
    let source = points[0].position;
    for point in &mut points {
        point.position -= source;
        point.color = color;
    }
    let key = Light::new(LightShape::Bendy(points));
    key.with(NAME, "key".into()).with(TRANSLATION, source).with(CONE_SOFTNESS, 0.3)
}

/// Returns an opaque material without textures.
pub fn paint([r, g, b]: [f32; 3], roughness: f32) -> Material {
    Material { base_color: Vec4::new(r, g, b, 1.0), roughness, ..Material::default() }
}

/// Adds a node called `name`, with `surface` as its only primitive.
pub fn add_node(scene: &mut Scene, name: &str, mut material: Material, surface: Primitive, at: DAffine3) {
    let primitive = Primitive { material: scene.materials.len(), ..surface };
    material.name = name.into();
    scene.materials.push(material);
    let mesh = Some(scene.meshes.len());
    scene.nodes.push(Node { name: name.into(), parent: None, parent_from_local: at, mesh });
    scene.meshes.push(Mesh { name: name.into(), primitives: vec![primitive] });
}

/// Returns a demo scene with its light and its camera.
pub fn loaded(scene: Scene, key: Light, camera: Camera) -> LoadedScene {
    let key = CheckedLight::new(key).expect("the demo's own light");
    let contents = SceneContents { lights: vec![Arc::new(key)], cameras: vec![camera] };
    LoadedScene { scene, contents, name: None, notes: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn background_faces_the_stage_and_has_large_triangles() {
        let stage = Cyclorama { half_width: 4.0, front_z: 3.0, bend_z: -2.0, bend_radius: 1.0, height: 3.0, strips: 8 };
        let made = stage.surface();
        let (triangles, _) = made.indices.as_chunks::<3>();
        for t in triangles {
            let [a, b, c] = t.map(|i| made.positions[i as usize].as_dvec3());
            let across = (b - a).cross(c - a);
            for i in t {
                assert!(across.dot(made.normals[*i as usize].as_dvec3()) > 0.0);
            }
        }
        let floor = triangles.iter().filter(|t| t.iter().all(|&i| made.positions[i as usize].y == 0.0));
        assert_eq!(floor.count(), 2);
    }
}

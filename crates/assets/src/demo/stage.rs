//! Background, camera rotation and contents that the demo scenes share.

use std::sync::Arc;

use document::SceneContents;
use light::{CheckedLight, Light};
use scene::Camera;
use std::f64::consts::FRAC_PI_2;

use glam::{DMat3, DQuat, DVec3};
use scene::Primitive;

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

/// Returns the rotation of a camera at `eye` that looks at `target`, with +Y up.
pub fn look_at(eye: DVec3, target: DVec3) -> DQuat {
    let back = (eye - target).normalize();
    let right = DVec3::Y.cross(back).normalize();
    DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back))
}

/// Returns the light and the camera of a demo scene as its contents.
pub fn contents(key: Light, camera: Camera) -> SceneContents {
    let key = CheckedLight::new(key).expect("the demo's own light");
    SceneContents { lights: vec![Arc::new(key)], cameras: vec![camera] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn background_faces_the_stage_and_has_large_triangles() {
        let stage = Cyclorama {
            half_width: 4.0,
            front_z: 3.0,
            bend_z: -2.0,
            bend_radius: 1.0,
            height: 3.0,
            strips: 8,
        };
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

//! Straight and bent rays against closed forms and brute force.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

mod bent_paths;
mod straight_rays;

use glam::{DAffine3, Vec3};
use raycast::Bvh;
use scene::{Material, Mesh, Node, Primitive, Scene};

/// Prepares a scene of one mesh.
fn bvh_of(positions: Vec<Vec3>, indices: Vec<u32>, world_from_local: DAffine3) -> Bvh {
    let primitive = Primitive { normals: vec![Vec3::Y; positions.len()], positions, indices, ..Primitive::default() };
    Bvh::new(scene::pose(
        Scene {
            nodes: vec![Node { name: "mesh".into(), parent: None, parent_from_local: world_from_local, mesh: Some(0) }],
            meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
            materials: vec![Material::default()],
            ..Scene::default()
        },
        0.0,
    ))
}

//! Import of cameras, with their world transforms.

use glam::DQuat;
use gltf::json::camera::{Camera, Type};
use gltf::json::validation::Checked;
use scene::Projection;

use super::nodes::PlacedNode;
use super::placement::rigid;
use super::{ImportSource, display_name};
use crate::notes::Notes;

/// Returns every camera of the drawn scene, in node order. Cameras with invalid numbers are left out, with a
/// note.
pub fn read(source: &ImportSource, nodes: &[PlacedNode], notes: &mut Notes) -> Vec<scene::Camera> {
    let mut cameras = Vec::new();
    for placed in nodes {
        let Some(node) = placed.node.map(|index| &source.root.nodes[index]) else { continue };
        let Some(camera) = node.camera.and_then(|camera| source.root.get(camera)) else { continue };
        let name = display_name(node.name.as_deref().or(camera.name.as_deref()), "camera", cameras.len());
        match projection(camera) {
            Some(projection) => {
                if declared_aspect(camera).is_some_and(|aspect| !is_aspect(aspect)) {
                    notes.add("camera widths that are not more than 0 are ignored", name.clone());
                }
                let placed = rigid(&placed.world_from_local);
                let rotation = DQuat::from_mat3(&placed.matrix3);
                cameras.push(scene::Camera { name, translation: placed.translation, rotation, projection });
            }
            None => notes.add("cameras whose angle or planes make no picture are left out", name),
        }
    }
    cameras
}

/// Returns the projection, or `None` if a number is outside its documented domain.
fn projection(camera: &Camera) -> Option<Projection> {
    let aspect_ratio = declared_aspect(camera).filter(|&aspect| is_aspect(aspect));
    let projection = match (&camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(p), _) => {
            let (yfov, znear, zfar) = (p.yfov.into(), p.znear.into(), p.zfar.map(f64::from));
            Projection::Perspective { yfov, aspect_ratio, znear, zfar }
        }
        (Checked::Valid(Type::Orthographic), _, Some(o)) => {
            let (ymag, znear, zfar) = (o.ymag.into(), o.znear.into(), o.zfar.into());
            Projection::Orthographic { ymag, aspect_ratio, znear, zfar }
        }
        _ => return None,
    };
    projection.makes_a_picture().then_some(projection)
}

/// Returns width over height of the frame, as the file declares it.
fn declared_aspect(camera: &Camera) -> Option<f64> {
    match (&camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(p), _) => p.aspect_ratio.map(f64::from),
        (Checked::Valid(Type::Orthographic), _, Some(o)) => Some(f64::from(o.xmag) / f64::from(o.ymag)),
        _ => None,
    }
}

fn is_aspect(aspect: f64) -> bool {
    0.0 < aspect && aspect.is_finite()
}

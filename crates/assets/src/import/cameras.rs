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
pub fn read(source: &ImportSource, places: &[PlacedNode], notes: &mut Notes) -> Vec<scene::Camera> {
    let mut cameras = Vec::new();
    for place in places {
        let Some(node) = place.node.map(|index| &source.root.nodes[index]) else { continue };
        let Some(camera) = node.camera.and_then(|camera| source.root.get(camera)) else { continue };
        let name = display_name(node.name.as_deref().or(camera.name.as_deref()), "camera", cameras.len());
        match projection(camera) {
            Some(projection) => {
                if declared_aspect(camera).is_some_and(|aspect| !is_aspect(aspect)) {
                    notes.add("camera widths that are not more than 0 are ignored", name.clone());
                }
                let placed = rigid(&place.world_from_local);
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
    match (&camera.type_, &camera.perspective, &camera.orthographic) {
        (Checked::Valid(Type::Perspective), Some(p), _) => {
            let (yfov, znear, zfar) = (f64::from(p.yfov), f64::from(p.znear), p.zfar.map(f64::from));
            let sound =
                0.0 < yfov && yfov < std::f64::consts::PI && 0.0 < znear && are_planes_valid(znear, zfar);
            sound.then_some(Projection::Perspective { yfov, aspect_ratio, znear, zfar })
        }
        (Checked::Valid(Type::Orthographic), _, Some(o)) => {
            let (ymag, znear, zfar) = (f64::from(o.ymag), f64::from(o.znear), f64::from(o.zfar));
            let sound = 0.0 < ymag && ymag.is_finite() && 0.0 <= znear && are_planes_valid(znear, Some(zfar));
            sound.then_some(Projection::Orthographic { ymag, aspect_ratio, znear, zfar })
        }
        _ => None,
    }
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

fn are_planes_valid(znear: f64, zfar: Option<f64>) -> bool {
    znear.is_finite() && zfar.is_none_or(|zfar| znear < zfar && zfar.is_finite())
}

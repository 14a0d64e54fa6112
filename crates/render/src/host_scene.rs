//! A scene as the processor draws it.

use relight::{AlphaTests, Hierarchy, Links, Scene};

use crate::gpu_scene::GpuScene;
use crate::linked::Linked;

/// The scene as `linked` leaves it to a light.
pub(crate) fn arrays<'a>(scene: &'a GpuScene, linked: Option<&'a Linked>) -> Scene<'a> {
    let host = scene.geometry.host.as_deref().expect("it is there where the processor draws");
    let vertices = &host.vertices;
    Scene {
        positions: &vertices.positions,
        indices: &vertices.indices,
        planes: &vertices.planes,
        hierarchy: Hierarchy {
            nodes: bytemuck::cast_slice(&host.hierarchy.nodes),
            triangles: &host.hierarchy.triangles,
        },
        attributes: bytemuck::cast_slice(&vertices.attributes),
        opaque_triangles: scene.opaque_indices / 3,
        alpha_tests: scene.alpha_tests.as_ref().map_or_else(AlphaTests::default, |tests| tests.host()),
        links: Links { bits: linked.and_then(|linked| linked.host_bits.as_deref()) },
    }
}

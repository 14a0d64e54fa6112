//! The scene for the native backend.

use relight::{AlphaTests, CasterHierarchy, CasterLinks, CasterScene};

use crate::gpu_scene::{GpuScene, HostMaterials};
use crate::linked::LinkedCasters;

/// Returns the materials of the scene.
pub(crate) fn host_materials(scene: &GpuScene) -> &HostMaterials {
    scene.host_materials.as_ref().expect("they are there where the processor draws")
}

/// Returns the scene as shadow casters, reduced by `linked`.
pub(crate) fn caster_scene<'a>(scene: &'a GpuScene, linked: Option<&'a LinkedCasters>) -> CasterScene<'a> {
    let host = scene.geometry.host.as_deref().expect("it is there where the processor draws");
    let vertices = &host.vertices;
    CasterScene {
        positions: &vertices.positions,
        indices: &vertices.indices,
        planes: &vertices.planes,
        hierarchy: CasterHierarchy { nodes: &host.hierarchy.nodes, triangles: &host.hierarchy_triangles },
        attributes: bytemuck::cast_slice(&vertices.attributes),
        opaque_triangles: scene.opaque_indices / 3,
        alpha_tests: scene.alpha_tests.as_ref().map_or_else(AlphaTests::default, |tests| tests.host()),
        links: CasterLinks { bits: linked.and_then(|linked| linked.host_bits.as_deref()) },
    }
}

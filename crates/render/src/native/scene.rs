//! A scene in CPU memory.

use std::sync::Arc;

use hierarchy::Hierarchy;
use relight::{AlphaTest, AlphaTests, CasterHierarchy, CasterLinks, CasterScene};

use super::Native;
use super::material::HostMaterials;
use crate::RenderError;
use crate::frame::SceneParts;
use crate::frame::geometry::Vertices;
use crate::frame::linked::LinkedCasters;
use crate::frame::shared_scene::FrameScene;
use crate::native::Cpu;

/// Geometry and materials in CPU memory.
#[derive(Debug)]
pub(crate) struct HostScene {
    pub vertices: Vertices,
    /// Tree of the posed scene.
    pub hierarchy: Arc<Hierarchy>,
    /// The triangles in the order of the hierarchy's leaves.
    pub hierarchy_triangles: Vec<u32>,
    pub materials: HostMaterials,
}

/// Shadow casters in CPU memory.
#[derive(Debug)]
pub(crate) struct HostCasters {
    pub positions: Vec<[f32; 3]>,
    /// Three per triangle; triangles without an alpha test come first.
    pub indices: Vec<u32>,
}

/// Alpha tests in CPU memory, with the texels that they read.
#[derive(Debug)]
pub(crate) struct HostAlphaTests {
    pub tests: Vec<AlphaTest>,
    pub texels: Arc<[u8]>,
}

impl HostScene {
    /// Makes the scene. Also returns its bytes, without those that grow only with materials and nodes.
    pub fn new(cpu: &Cpu, parts: SceneParts) -> Result<(Self, u64), RenderError> {
        let SceneParts { posed, vertices, hierarchy, hierarchy_triangles } = parts;
        let materials = HostMaterials::new(cpu, &posed.scene, &vertices)?;
        let Vertices { positions, attributes, indices, planes, .. } = &vertices;
        let of_triangles = size_of_val(&indices[..]) + size_of_val(&planes[..]);
        let of_vertices = size_of_val(&positions[..]) + size_of_val(&attributes[..]);
        let of_hierarchy = size_of_val(&hierarchy.nodes[..]) + size_of_val(&hierarchy_triangles[..]);
        let bytes = (of_vertices + of_triangles + of_hierarchy) as u64 + materials.bytes();
        Ok((Self { vertices, hierarchy, hierarchy_triangles, materials }, bytes))
    }
}

impl HostAlphaTests {
    pub fn all(&self) -> AlphaTests<'_> {
        AlphaTests { tests: &self.tests, texels: &self.texels }
    }
}

/// Returns the scene as shadow casters, reduced by `linked`.
pub(crate) fn caster_scene<'a>(
    scene: &'a FrameScene<Native>,
    linked: Option<&'a LinkedCasters<Native>>,
) -> CasterScene<'a> {
    let HostScene { vertices, hierarchy, hierarchy_triangles, .. } = &scene.uploaded;
    CasterScene {
        positions: &vertices.positions,
        indices: &vertices.indices,
        planes: &vertices.planes,
        hierarchy: CasterHierarchy { nodes: &hierarchy.nodes, triangles: hierarchy_triangles },
        attributes: bytemuck::cast_slice(&vertices.attributes),
        opaque_triangles: scene.opaque_indices / 3,
        alpha_tests: scene.alpha_tests.as_ref().map_or_else(AlphaTests::default, |(_, tests)| tests.all()),
        links: CasterLinks { bits: linked.map(|linked| &linked.links[..]) },
    }
}

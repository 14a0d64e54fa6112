//! Selects the triangles of a scene that a light lights and that cast its shadows, by its links.

use std::sync::{Arc, OnceLock, Weak};

use light::Links;
use light::parameters::{LIGHT_LINK, SHADOW_LINK};
use relight::AlphaTest;

use super::alpha_test::AlphaTestedDraw;
use super::casters::{CasterSet, Casters};
use super::geometry::{DrawRun, Vertices};
use super::memory::{MemoryKind, Reservation};
use super::scene_backend::SceneBackend;
use super::shared_scene::FrameScene;
use crate::RenderError;

/// `lightLink` and `shadowLink` of a light.
type LinkPair = [Option<Links>; 2];

/// Triangles of a scene that a light's links select.
#[derive(Debug)]
pub(crate) struct LinkedCasters<B: SceneBackend> {
    pub links: B::Links,
    /// One entry per node, true if it casts shadows. `None` if all nodes do.
    casts_shadows: Option<Vec<bool>>,
    /// Casters that the links select, made when the first map is drawn.
    casters: OnceLock<LinkedCasterMeshes<B>>,
    _memory: Reservation,
}

#[derive(Debug)]
struct LinkedCasterMeshes<B: SceneBackend> {
    casters: Casters<B>,
    alpha_tested: Vec<AlphaTestedDraw>,
    alpha_tests: Option<B::AlphaTests>,
    _memory: Reservation,
}

/// Triangles that the links of lights in use select, by scene revision and links. Lights with the same links share one
/// entry.
#[derive(Debug)]
pub(crate) struct KnownLinks<B: SceneBackend>(Vec<(LinkKey, Weak<LinkedCasters<B>>)>);

/// Scene revision, and links.
type LinkKey = (u64, LinkPair);

impl<B: SceneBackend> Default for KnownLinks<B> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<B: SceneBackend> KnownLinks<B> {
    /// Returns the triangles that the links of `light` select in `scene`. `None` if the light has no links.
    pub fn get(&mut self, backend: &B, scene: &FrameScene<B>, light: &light::Light) -> Option<Arc<LinkedCasters<B>>> {
        let pair = [light.get(LIGHT_LINK), light.get(SHADOW_LINK)];
        if pair == [None, None] {
            return None;
        }
        let key = (scene.revision, pair);
        self.0.retain(|(_, linked)| linked.strong_count() > 0);
        let kept = self.0.iter().find(|(of, _)| *of == key).and_then(|(_, linked)| linked.upgrade());
        Some(kept.unwrap_or_else(|| {
            let linked = Arc::new(LinkedCasters::new(backend, scene, &key.1));
            self.0.push((key, Arc::downgrade(&linked)));
            linked
        }))
    }
}

/// Returns the shadow casters of a light with these links, within `mesh_error` of the surface in world units.
pub(crate) fn caster_set<'a, B: SceneBackend>(
    device: &B::Device,
    scene: &'a FrameScene<B>,
    linked: Option<&'a LinkedCasters<B>>,
    mesh_error: f64,
) -> Result<CasterSet<'a, B>, RenderError> {
    linked.map_or_else(|| Ok(scene.all_casters()), |linked| linked.caster_set(device, scene, mesh_error))
}

impl<B: SceneBackend> LinkedCasters<B> {
    fn new(backend: &B, scene: &FrameScene<B>, pair: &LinkPair) -> Self {
        let [lit, casts_shadows] =
            pair.each_ref().map(|links| Some(scene.posed.node_tree().selected_nodes(links.as_ref()?)));
        let mut bits = vec![[0_u32; 2]; (scene.triangle_count as usize).div_ceil(32).max(1)];
        for run in &scene.runs {
            let counts = |nodes: &Option<Vec<bool>>| nodes.as_ref().is_none_or(|nodes| nodes[run.node]);
            let flags = [counts(&lit), counts(&casts_shadows)].map(u32::from);
            for triangle in run.indices.start / 3..run.indices.end / 3 {
                let word = &mut bits[triangle as usize / 32];
                *word = [0, 1].map(|k| word[k] | flags[k] << (triangle % 32));
            }
        }
        let (links, bytes) = backend.upload_links(bits);
        let memory = backend.host().memory.reserve(MemoryKind::Scenes, bytes);
        Self { links, casts_shadows, casters: OnceLock::new(), _memory: memory }
    }

    fn caster_set<'a>(
        &'a self,
        device: &B::Device,
        scene: &'a FrameScene<B>,
        mesh_error: f64,
    ) -> Result<CasterSet<'a, B>, RenderError> {
        let Some(casts_shadows) = &self.casts_shadows else { return Ok(scene.all_casters()) };
        let made = if let Some(made) = self.casters.get() {
            made
        } else {
            let made = LinkedCasterMeshes::new(device, scene, casts_shadows, mesh_error)?;
            self.casters.get_or_init(|| made)
        };
        let LinkedCasterMeshes { casters, alpha_tested, alpha_tests, .. } = made;
        Ok(CasterSet { casters, alpha_tested, alpha_tests: alpha_tests.as_ref() })
    }
}

impl<B: SceneBackend> LinkedCasterMeshes<B> {
    fn new(
        device: &B::Device,
        scene: &FrameScene<B>,
        casts_shadows: &[bool],
        mesh_error: f64,
    ) -> Result<Self, RenderError> {
        let posed = &scene.posed;
        let runs: Vec<&DrawRun> = scene.runs.iter().filter(|run| casts_shadows[run.node]).collect();
        let triangles = runs.iter().flat_map(|run| {
            let own = posed.triangles(&posed.primitives[run.primitive]);
            own.map(|corners| corners.map(|k| run.first_vertex + k))
        });
        let indices: Vec<u32> = triangles.flatten().collect();
        let is_alpha_tested = |run: &&&DrawRun| run.indices.start >= scene.opaque_indices;
        let opaque_indices = runs.iter().filter(|run| !is_alpha_tested(run)).map(|run| run.indices.len()).sum();
        let vertices = Vertices { indices, ..Vertices::new(posed)? };
        let casters = Casters::new(device, (&vertices, opaque_indices), mesh_error)?;
        let (alpha_tested, alpha_tests) =
            linked_alpha_tests(device, scene, runs.iter().filter(is_alpha_tested).copied())?;
        let bytes = casters.bytes() + alpha_tests.as_ref().map_or(0, B::alpha_test_bytes);
        let memory = B::host_of(device).memory.reserve(MemoryKind::Scenes, bytes);
        Ok(Self { casters, alpha_tested, alpha_tests, _memory: memory })
    }
}

/// Returns the draws of `runs`, all of which are alpha-tested, and their alpha tests. Triangles are numbered within
/// `runs`.
fn linked_alpha_tests<'a, B: SceneBackend>(
    device: &B::Device,
    scene: &FrameScene<B>,
    runs: impl Iterator<Item = &'a DrawRun>,
) -> Result<(Vec<AlphaTestedDraw>, Option<B::AlphaTests>), RenderError> {
    let Some((known, on_device)) = &scene.alpha_tests else { return Ok((Vec::new(), None)) };
    let mut first_triangle = 0;
    let (mut draws, mut tests) = (Vec::new(), Vec::new());
    for run in runs {
        let index = scene.alpha_tested.partition_point(|draw| draw.indices.end <= run.indices.start);
        draws.push(AlphaTestedDraw { draw: scene.alpha_tested[index].draw, indices: run.indices.clone() });
        tests.push(AlphaTest { first_triangle, first_index: run.indices.start, ..known[index] });
        first_triangle += run.indices.len() as u32 / 3;
    }
    let tests = if tests.is_empty() { None } else { Some(B::replace_alpha_tests(device, on_device, tests)?) };
    Ok((draws, tests))
}

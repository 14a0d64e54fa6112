//! Selects the triangles of a scene that a light lights and that cast its shadows, by its links.

use std::sync::{Arc, OnceLock, Weak};

use light::Links;
use light::parameters::{LIGHT_LINK, SHADOW_LINK};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType};

use crate::alpha_test::GpuAlphaTests;
use crate::casters::{CasterSet, Casters};
use crate::geometry::{DrawRun, Vertices};
use crate::gpu_scene::GpuScene;
use crate::material::MaterialDraw;
use crate::memory::{MemoryKind, Reservation};
use crate::pipeline::UINT_TEXTURE;
use crate::{Gpu, RenderError, gpu_structs};

/// Group 3 of the lighting passes of lights with links; see `links.wgsl`.
pub(crate) const BINDINGS: [BindingType; 1] = [UINT_TEXTURE];

/// Texels per row of the texture that stores the selected triangles as bits.
const TEXELS_PER_ROW: usize = 1024;

/// `lightLink` and `shadowLink` of a light.
type LinkPair = [Option<Links>; 2];

/// Triangles of a scene that a light's links select.
#[derive(Debug)]
pub(crate) struct LinkedCasters {
    /// Group 3 of the lighting pass of a light with these links.
    pub group: BindGroup,
    /// Content of the texture in `group`, for the native backend: two words for each 32 triangles, with one bit per
    /// triangle. `[0]` is set if the light lights the triangle, `[1]` if the triangle casts shadows.
    pub host_bits: Option<Arc<[[u32; 2]]>>,
    /// One entry per node, true if it casts shadows. `None` if all nodes do.
    casts_shadows: Option<Vec<bool>>,
    /// Casters that the links select, made when the first map is drawn.
    casters: OnceLock<LinkedCasterMeshes>,
    _memory: Reservation,
}

#[derive(Debug)]
struct LinkedCasterMeshes {
    casters: Casters,
    alpha_tested: Vec<MaterialDraw>,
    alpha_tests: Option<GpuAlphaTests>,
    _memory: Reservation,
}

/// Triangles that the links of lights in use select, by scene revision and links. Lights with the same links share one
/// entry.
#[derive(Debug, Default)]
pub(crate) struct KnownLinks(Vec<((u64, LinkPair), Weak<LinkedCasters>)>);

impl KnownLinks {
    /// Returns the triangles that the links of `light` select in `scene`. `None` if the light has no links.
    pub fn get(
        &mut self,
        gpu: &Gpu,
        layout: &BindGroupLayout,
        scene: &GpuScene,
        light: &light::Light,
    ) -> Option<Arc<LinkedCasters>> {
        let pair = [light.get(LIGHT_LINK), light.get(SHADOW_LINK)];
        if pair == [None, None] {
            return None;
        }
        let key = (scene.revision, pair);
        self.0.retain(|(_, linked)| linked.strong_count() > 0);
        let kept = self.0.iter().find(|(of, _)| *of == key).and_then(|(_, linked)| linked.upgrade());
        Some(kept.unwrap_or_else(|| {
            let linked = Arc::new(LinkedCasters::new(gpu, layout, scene, &key.1));
            self.0.push((key, Arc::downgrade(&linked)));
            linked
        }))
    }
}

/// Returns the shadow casters of a light with these links, within `mesh_error` of the surface in world units.
pub(crate) fn caster_set<'a>(
    gpu: &Gpu,
    scene: &'a GpuScene,
    linked: Option<&'a LinkedCasters>,
    mesh_error: f64,
) -> Result<CasterSet<'a>, RenderError> {
    linked.map_or_else(|| Ok(scene.all_casters()), |linked| linked.caster_set(gpu, scene, mesh_error))
}

impl LinkedCasters {
    fn new(gpu: &Gpu, layout: &BindGroupLayout, scene: &GpuScene, pair: &LinkPair) -> Self {
        let [lit, casts_shadows] =
            pair.each_ref().map(|links| Some(scene.posed.node_tree().selected_nodes(links.as_ref()?)));
        let triangles = scene.triangle_count as usize;
        let words = triangles.div_ceil(32).max(1);
        let (width, height) = (words.min(TEXELS_PER_ROW), words.div_ceil(TEXELS_PER_ROW));
        let mut bits = vec![[0_u32; 2]; width * height];
        for run in &scene.runs {
            let counts = |nodes: &Option<Vec<bool>>| nodes.as_ref().is_none_or(|nodes| nodes[run.node]);
            let flags = [counts(&lit), counts(&casts_shadows)].map(u32::from);
            for triangle in run.indices.start / 3..run.indices.end / 3 {
                let word = &mut bits[triangle as usize / 32];
                *word = [0, 1].map(|k| word[k] | flags[k] << (triangle % 32));
            }
        }
        let (size, format) = ([width as u32, height as u32], wgpu::TextureFormat::Rg32Uint);
        let view = gpu.texture_with("links", size, (format, 1), bytemuck::cast_slice(&bits));
        let group = gpu.bind_group("links", layout, &[BindingResource::TextureView(&view)]);
        let bytes = size_of_val(&bits[..]) as u64;
        let host_bits: Option<Arc<[_]>> = gpu.if_native(|| bits.into());
        let host_bytes = host_bits.as_ref().map_or(0, |_| bytes);
        let memory = gpu.memory.reserve(MemoryKind::Scenes, bytes + host_bytes);
        Self { group, host_bits, casts_shadows, casters: OnceLock::new(), _memory: memory }
    }

    fn caster_set<'a>(&'a self, gpu: &Gpu, scene: &'a GpuScene, mesh_error: f64) -> Result<CasterSet<'a>, RenderError> {
        let Some(casts_shadows) = &self.casts_shadows else { return Ok(scene.all_casters()) };
        let made = if let Some(made) = self.casters.get() {
            made
        } else {
            let made = LinkedCasterMeshes::new(gpu, scene, casts_shadows, mesh_error)?;
            self.casters.get_or_init(|| made)
        };
        let LinkedCasterMeshes { casters, alpha_tested, alpha_tests, .. } = made;
        Ok(CasterSet { casters, alpha_tested, alpha_tests: alpha_tests.as_ref() })
    }
}

impl LinkedCasterMeshes {
    fn new(gpu: &Gpu, scene: &GpuScene, casts_shadows: &[bool], mesh_error: f64) -> Result<Self, RenderError> {
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
        let casters = Casters::new(gpu, (&vertices, opaque_indices), mesh_error)?;
        let (alpha_tested, alpha_tests) = linked_alpha_tests(gpu, scene, runs.iter().filter(is_alpha_tested).copied())?;
        let bytes = casters.bytes() + alpha_tests.as_ref().map_or(0, |tests| tests.tests.size());
        let memory = gpu.memory.reserve(MemoryKind::Scenes, bytes);
        Ok(Self { casters, alpha_tested, alpha_tests, _memory: memory })
    }
}

/// Returns the draws of `runs`, all of which are alpha-tested, and their alpha tests. Triangles are numbered within
/// `runs`.
fn linked_alpha_tests<'a>(
    gpu: &Gpu,
    scene: &GpuScene,
    runs: impl Iterator<Item = &'a DrawRun>,
) -> Result<(Vec<MaterialDraw>, Option<GpuAlphaTests>), RenderError> {
    let Some(of_scene) = &scene.alpha_tests else { return Ok((Vec::new(), None)) };
    let all = scene.alpha_tested_draws();
    let mut first_triangle = 0;
    let (mut draws, mut tests): (Vec<MaterialDraw>, Vec<_>) = (Vec::new(), Vec::new());
    for run in runs {
        let draw = all.partition_point(|draw| draw.indices.end <= run.indices.start);
        draws.push(MaterialDraw { indices: run.indices.clone(), ..all[draw].clone() });
        let first_index = run.indices.start;
        tests.push(gpu_structs::AlphaTest { first_triangle, first_index, ..of_scene.list[draw] });
        first_triangle += run.indices.len() as u32 / 3;
    }
    let tests = if tests.is_empty() { None } else { Some(of_scene.with_tests(gpu, tests)?) };
    Ok((draws, tests))
}

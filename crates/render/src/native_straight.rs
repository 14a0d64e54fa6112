//! Lights with straight rays on the CPU: the light's numbers for `relight`, and its map.

use glam::{DMat3, DMat4, DVec3, DVec4, Mat4, Vec4Swizzles};
use relight::{
    AlphaTestedCasters, AlphaTestedRun, AlphaTests, DepthMap, DirectionalMapParams, OmniMapParams, OpaqueCasters,
    RelitDirectional, RelitOmni, RelitSpot, SpotMapParams, StraightFace, StraightMap, StraightMapBuilder,
};

use crate::casters::CasterSet;
use crate::clusters::VERTICES_PER_BLOCK;
use crate::host_scene::caster_scene;
use crate::in_view::leaves_in_view;
use crate::linked::CasterSource;
use crate::map_views::{LightUniform, MapViews, PlacedLight};
use crate::material::MaterialDraw;
use crate::shadow_settings::Culling;
use crate::stages::FrameStage;
use crate::straight::StraightLight;
use crate::{Gpu, RenderError, ShadowFilter, gpu_structs};

#[derive(Debug, Default)]
struct VisibleCasters {
    /// List of leaves for each face: the index of a leaf's first triangle; and its number of triangles in the low 16
    /// bits, with its [`crate::closed_components::TriangleComponent`] above.
    leaves: Vec<Vec<[u32; 2]>>,
    /// Indices of the blocks of vertices that the leaves use.
    blocks: Vec<u32>,
    triangles: u64,
}

impl VisibleCasters {
    fn new(casting: &CasterSet, views: &MapViews, source: Option<DVec3>, culling: Culling) -> Self {
        let casters = casting.casters;
        let mut is_near = vec![false; (casters.vertex_count as usize).div_ceil(VERTICES_PER_BLOCK)];
        let mut triangles = 0;
        let leaves_of = |view: &Option<gpu_structs::ShadowView>| {
            let mut leaves = Vec::new();
            let Some(view) = view else { return leaves };
            leaves_in_view(casters, &view.clip_from_scene, source, culling, |leaf, component| {
                let count = leaf.triangles.len() as u32;
                leaves.push([leaf.triangles.start, count | (component as u32) << 16]);
                triangles += u64::from(count);
                for &block in casters.clusters.blocks_of(leaf) {
                    is_near[block as usize] = true;
                }
            });
            leaves
        };
        let leaves = views.shadow_views().iter().map(leaves_of).collect();
        let blocks = (0_u32..).zip(is_near).filter_map(|(block, is_near)| is_near.then_some(block)).collect();
        Self { leaves, blocks, triangles }
    }
}

/// Draws the map of a light into `into`.
pub(crate) fn draw_map(
    gpu: &Gpu,
    work: &mut StraightMapBuilder,
    light: StraightLight,
    placed: &PlacedLight,
    casters: CasterSource,
    into: &mut DepthMap,
) -> Result<(), RenderError> {
    let CasterSource { scene, linked, shadows, .. } = casters;
    let casting = casters.caster_set(gpu)?;
    let source = light.source_in_world().map(|source| source - scene.posed.origin_in_world);
    let views = &placed.views;
    let seen = VisibleCasters::new(&casting, views, source, shadows.culling);
    let faces: Vec<_> = seen
        .leaves
        .iter()
        .zip(&views.clip_from_light)
        .map(|(leaves, clip_from_light)| StraightFace {
            clip_from_map: clip_from_map(views, clip_from_light.as_ref()).as_mat3(),
            leaves,
            has_casters: clip_from_light.is_some(),
        })
        .collect();
    let map = StraightMap {
        map_from_scene: (map_from_light(views) * views.light_from_scene).as_mat4(),
        near: views.near.map(|near| near as f32),
        faces: &faces,
    };
    let host = casting.casters.host.as_deref().expect("it is there where the processor draws");
    // Draw or linked run `k` has test `k`.
    let run = |(draw, test): (&MaterialDraw, u32)| AlphaTestedRun {
        triangles: draw.indices.start / 3..draw.indices.end / 3,
        test,
    };
    let runs: Vec<_> = casting.alpha_tested.iter().zip(0..).map(run).collect();
    let alpha_tested = AlphaTestedCasters {
        scene: &caster_scene(scene, linked),
        runs: &runs,
        tests: casting.alpha_tests.map_or_else(AlphaTests::default, |tests| tests.host()),
    };
    let casters = OpaqueCasters { positions: &host.positions, blocks: &seen.blocks, indices: &host.indices };
    work.draw(gpu.workers(), &map, &casters, &alpha_tested, into)?;
    gpu.stages.record_stage(FrameStage::Draw);
    gpu.stages.count(|counters| {
        counters.triangles_seen += seen.triangles;
        counters.triangles_drawn += seen.triangles;
        counters.texels += into.faces() as u64 * (into.side() as u64).pow(2);
    });
    Ok(())
}

/// Returns the matrix from light space to map space. It is the identity for a light with a source. For parallel rays
/// map space is (x, y, 1, depth).
fn map_from_light(views: &MapViews) -> DMat4 {
    match (views.near, &views.clip_from_light[..]) {
        (None, [Some(clip_from_light)]) => {
            DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::W, clip_from_light.row(2)).transpose()
        }
        _ => DMat4::IDENTITY,
    }
}

/// Returns the matrix from map space to (x, y, w) of a face.
fn clip_from_map(views: &MapViews, clip_from_light: Option<&DMat4>) -> DMat3 {
    let Some(clip_from_light) = clip_from_light else { return DMat3::IDENTITY };
    let [x, y, z, w] = [0, 1, 2, 3].map(|k| clip_from_light.col(k)).map(Vec4Swizzles::xyw);
    DMat3::from_cols(x, y, if views.near.is_some() { z } else { w })
}

/// Converts a light to the form that `relight` draws.
pub(crate) fn relit_light(placed: PlacedLight, filter: ShadowFilter) -> relight::RelitLight {
    let light_profile = placed.light_profile;
    let matrix = |columns: &gpu_structs::Mat4| Mat4::from_cols_array_2d(columns);
    let end = |range: f32| (range > 0.0).then_some(range);
    match placed.uniform {
        LightUniform::Spot(uniform) => {
            let gpu_structs::Spot { tan_outer, range, shadow_near, mesh_error, fits, .. } = uniform;
            let map = SpotMapParams { near: shadow_near, mesh_error, fits, filter };
            let spot = RelitSpot::new(matrix(&uniform.light_from_scene), light_profile, tan_outer, end(range), map);
            relight::RelitLight::Spot(Box::new(spot))
        }
        LightUniform::Omni(uniform) => {
            let gpu_structs::Omni { range, shadow_near, mesh_error, fits, .. } = uniform;
            let map = OmniMapParams { near: shadow_near, mesh_error, fits, filter };
            let omni = RelitOmni::new(matrix(&uniform.light_from_scene), light_profile, end(range), map);
            relight::RelitLight::Omni(Box::new(omni))
        }
        LightUniform::Directional(uniform) => {
            let gpu_structs::Directional { window, fit, bottom, depth_scale, mesh_error, .. } = uniform;
            let map = DirectionalMapParams { fit, bottom, depth_scale, mesh_error, filter };
            let sun = RelitDirectional::new(matrix(&uniform.light_from_scene), light_profile, window, map);
            relight::RelitLight::Directional(Box::new(sun))
        }
    }
}

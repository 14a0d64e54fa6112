//! Maps of lights with straight rays on the CPU.

use glam::{DMat3, DMat4, DVec4, Vec4Swizzles};
use relight::{AlphaTestedCasters, AlphaTestedRun, AlphaTests, DepthMap, OpaqueCasters, StraightFace, StraightMap};
use shadow::{PlacedStraight, VisibleLeaves};

use super::Native;
use super::scene::caster_scene;
use crate::RenderError;
use crate::frame::stages::FrameStage;
use crate::frame::{AlphaTestedDraw, MapSource};
use crate::native::Cpu;

/// Draws the map of a light into `into`.
pub(crate) fn draw_map(
    cpu: &Cpu,
    work: &mut relight::StraightMapBuilder,
    placed: &PlacedStraight,
    source: &MapSource<Native>,
    into: &mut DepthMap,
) -> Result<(), RenderError> {
    let &MapSource { scene, linked, casting, shadows } = source;
    let (clusters, source) = (&casting.casters.clusters, placed.source_in_scene);
    let seen = VisibleLeaves::new(clusters, &placed.clips_from_scene(), source, shadows.culling);
    let faces: Vec<_> = seen
        .faces
        .iter()
        .zip(&placed.clip_from_light)
        .map(|(leaves, clip_from_light)| StraightFace {
            clip_from_map: clip_from_map(placed, clip_from_light.as_ref()).as_mat3(),
            leaves,
            has_casters: clip_from_light.is_some(),
        })
        .collect();
    let map = StraightMap {
        map_from_scene: (map_from_light(placed) * placed.light_from_scene).as_mat4(),
        near: placed.near.map(|near| near as f32),
        faces: &faces,
    };
    let host = &casting.casters.uploaded;
    // Draw or linked run `k` has test `k`.
    let run = |(draw, test): (&AlphaTestedDraw, u32)| AlphaTestedRun {
        triangles: draw.indices.start / 3..draw.indices.end / 3,
        test,
    };
    let runs: Vec<_> = casting.alpha_tested.iter().zip(0..).map(run).collect();
    let alpha_tested = AlphaTestedCasters {
        scene: &caster_scene(scene, linked),
        runs: &runs,
        tests: casting.alpha_tests.map_or_else(AlphaTests::default, |tests| tests.all()),
    };
    let casters = OpaqueCasters { positions: &host.positions, blocks: &seen.blocks, indices: &host.indices };
    work.draw(cpu.workers(), &map, &casters, &alpha_tested, into)?;
    cpu.host.stages.record_stage(FrameStage::Draw);
    cpu.host.stages.count(|counters| {
        counters.triangles_seen += seen.triangles;
        counters.triangles_drawn += seen.triangles;
        counters.texels += into.faces() as u64 * (into.side() as u64).pow(2);
    });
    Ok(())
}

/// Returns the matrix from light space to map space. It is the identity for a light with a source. For parallel rays
/// map space is (x, y, 1, depth).
fn map_from_light(placed: &PlacedStraight) -> DMat4 {
    match (placed.near, &placed.clip_from_light[..]) {
        (None, [Some(clip_from_light)]) => {
            DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::W, clip_from_light.row(2)).transpose()
        }
        _ => DMat4::IDENTITY,
    }
}

/// Returns the matrix from map space to (x, y, w) of a face.
fn clip_from_map(placed: &PlacedStraight, clip_from_light: Option<&DMat4>) -> DMat3 {
    let Some(clip_from_light) = clip_from_light else { return DMat3::IDENTITY };
    let [x, y, z, w] = [0, 1, 2, 3].map(|k| clip_from_light.col(k)).map(Vec4Swizzles::xyw);
    DMat3::from_cols(x, y, if placed.near.is_some() { z } else { w })
}

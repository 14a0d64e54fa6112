//! Times and work counts of frames, summarized.

use render::{FrameStage, Recording, StageCost, WorkCounters};
use serde::Serialize;

use crate::Quantiles;

/// Wall and CPU time of repeated work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Costs {
    /// Milliseconds that passed.
    pub wall_ms: Quantiles,
    /// Milliseconds of the whole process on all cores; includes the threads of a driver that draws on the CPU.
    pub cpu_ms: Quantiles,
}

/// Times of a stage in the frames of an edit.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct StageCosts {
    pub stage: &'static str,
    /// Number of runs in one frame.
    pub runs: u64,
    /// Times of all runs in one frame together.
    #[serde(flatten)]
    pub costs: Costs,
}

/// Amounts of work in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct WorkCounts {
    /// Triangles that were considered for shadow maps, counted once per map.
    pub triangles_seen: u64,
    /// For bent maps: pairs of triangle and slab that were clipped, and split if clipping was not enough.
    pub triangles_split: u64,
    /// Triangles passed to the rasterizer for shadow maps.
    pub triangles_drawn: u64,
    /// Texels of the maps drawn.
    pub texels: u64,
    /// Pixels of the scissor rectangles in which lights were added; pixels outside of the tube count too.
    pub scissor_pixels: u64,
    /// Bytes of the picture read back; 0 if the CPU made it.
    pub bytes: u64,
}

impl Costs {
    pub(super) fn of(costs: &[StageCost]) -> Self {
        Self {
            wall_ms: Quantiles::of(costs.iter().map(|cost| cost.wall_ms)),
            cpu_ms: Quantiles::of(costs.iter().map(|cost| cost.cpu_ms)),
        }
    }
}

impl StageCosts {
    /// Costs of every stage, over recordings of equal frames.
    pub(super) fn of(recordings: &[Recording]) -> Vec<Self> {
        let of_stage = |stage: FrameStage| {
            let costs: Vec<StageCost> = recordings.iter().map(|recording| recording.cost(stage)).collect();
            let runs = recordings.last().map_or(0, |recording| recording.runs(stage));
            Self { stage: stage.name(), runs, costs: Costs::of(&costs) }
        };
        FrameStage::ALL.into_iter().map(of_stage).collect()
    }
}

impl From<WorkCounters> for WorkCounts {
    fn from(counters: WorkCounters) -> Self {
        let WorkCounters { triangles_seen, triangles_split, triangles_drawn, texels, scissor_pixels, bytes } = counters;
        Self { triangles_seen, triangles_split, triangles_drawn, texels, scissor_pixels, bytes }
    }
}

//! Many measurements in few numbers.

use render::{FrameStage, Recording, StageCost, WorkCounters};
use serde::Serialize;

use crate::Quantiles;

/// What some work took, of many times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Costs {
    /// Milliseconds that passed.
    pub wall_ms: Quantiles,
    /// Milliseconds of the whole process on all cores; with a driver that draws on the processor, its threads too.
    pub cpu_ms: Quantiles,
}

/// What a stage took in the frames of an edit.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct StageCosts {
    /// The stage's name.
    pub stage: &'static str,
    /// How often it ran in one frame.
    pub runs: u64,
    /// All its runs of one frame together.
    #[serde(flatten)]
    pub costs: Costs,
}

/// How much one frame has worked on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct WorkCounts {
    /// Triangles looked at for shadow maps, once a map.
    pub triangles_seen: u64,
    /// Of a bent map: pairs of triangle and slab that were clipped, and split where that was not enough.
    pub triangles_split: u64,
    /// Triangles handed to the rasteriser for shadow maps.
    pub triangles_drawn: u64,
    /// Texels of the maps drawn.
    pub texels: u64,
    /// Pixels of the rectangles in which lights were added; what is beside the tube in them counts too.
    pub scissor_pixels: u64,
    /// Bytes of the picture read back; none where the processor has made it.
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
    /// Of every stage, of frames that were alike.
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
        let WorkCounters { triangles_seen, triangles_split, triangles_drawn, texels, scissor_pixels, bytes } =
            counters;
        Self { triangles_seen, triangles_split, triangles_drawn, texels, scissor_pixels, bytes }
    }
}

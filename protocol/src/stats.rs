//! Statistics of pictures: passes, their causes and times (SPEC, FRAME-13 and TRACE-1).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Statistics of one frame, sent to clients that asked for them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct FrameStats {
    /// Frame number, as in the frame's header.
    pub frame: u64,
    /// Microseconds from the change to the start of the render, as in the header.
    pub wait_us: u32,
    /// Microseconds of the render, as in the header.
    pub render_us: u32,
    /// Microseconds of the encoding, as in the header.
    pub encode_us: u32,
    /// Bytes of the frame's messages, headers included.
    pub bytes: u64,
    /// Number of messages, one per tile.
    pub tiles: u32,
    /// Width and height of the picture in pixels.
    pub size: [u32; 2],
    /// Divisor of the texels a side of shadow maps: 1 at full resolution.
    pub shadow_map_divisor: u16,
    pub quality: FrameQuality,
    /// Passes that ran for the picture. Empty if the picture came from the cache.
    pub passes: Vec<PassRun>,
}

/// Quality of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum FrameQuality {
    /// Fast and lossy: something in the view moves.
    Moving,
    /// Lossless and in full: nothing in the view moves.
    Settled,
}

/// Runs of a pass for one cause in one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct PassRun {
    pub pass: Pass,
    /// Id of the pass's light; `null` if the pass belongs to no light.
    pub light: Option<u64>,
    /// Cause of the runs: the reason that the cached result was not used.
    pub cause: Cause,
    /// Number of runs, over all samples and tiles of the picture.
    pub runs: u32,
}

/// Kind of pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Pass {
    /// Surface of each pixel.
    Gbuffer,
    /// Shadow map of a light.
    ShadowMap,
    /// Fill light, and lights without layers.
    Lighting,
    /// Contribution of one light.
    Layer,
    /// Sum of the layers of several lights.
    Sum,
    /// Tone-mapped picture for a screen.
    Display,
}

/// Reason that a pass ran instead of using a cached result.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Cause {
    /// No result existed yet.
    First,
    /// The scene changed.
    Scene,
    /// The camera moved, or the picture changed its size.
    Camera,
    /// The G-buffer changed.
    Gbuffer,
    /// A light changed.
    Light,
    /// The existing result has a lower resolution or another size.
    Resolution,
    /// The existing result was evicted to free memory.
    Evicted,
    /// The result is never cached: it belongs to one picture, tile or sample.
    NotKept,
}

/// Line of the file that `bendylights serve --trace` writes, for one picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct TraceLine {
    /// Start of the render, in seconds since the server started.
    pub time: f64,
    /// Name of the session.
    pub session: String,
    /// Subject of the picture.
    pub what: TraceWhat,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Quality of the picture. Stills are settled.
    pub quality: FrameQuality,
    /// Microseconds until the start of the render: from the change, or for a still from the request.
    pub wait_us: u32,
    /// Microseconds of the render, without the work for other pictures in between.
    pub render_us: u32,
    /// Microseconds of the encoding; `null` if a newer picture superseded this one before it was encoded.
    pub encode_us: Option<u32>,
    /// Passes that ran for the picture.
    pub passes: Vec<PassRun>,
    /// Number of lines missing before this one because the disk was too slow.
    #[serde(default, skip_serializing_if = "is_none_left_out")]
    pub left_out: u64,
}

/// Subject of a traced picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase")]
pub enum TraceWhat {
    /// View of a client.
    View {
        /// Number of the client in its session.
        client: u64,
    },
    /// Picture for an HTTP request.
    Still {},
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands fields over so")]
fn is_none_left_out(left_out: &u64) -> bool {
    *left_out == 0
}

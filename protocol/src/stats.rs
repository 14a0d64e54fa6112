//! What pictures came to: which passes ran, why, and how long it took (SPEC, FRAME-13 and TRACE-1).

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What a frame came to, for a client that asks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct FrameStats {
    /// The number in its header.
    pub frame: u64,
    /// Microseconds from the change to the start of the render, as in its header.
    pub wait_us: u32,
    /// Microseconds of the render, as in its header.
    pub render_us: u32,
    /// Microseconds of the encoding, as in its header.
    pub encode_us: u32,
    /// Bytes of its messages, headers included.
    pub bytes: u64,
    /// Its messages.
    pub tiles: u32,
    /// Width and height of its picture in pixels.
    pub size: [u32; 2],
    /// By how much the texels a side of shadow maps are divided: 1 where they are full.
    pub shadow_map_divisor: u16,
    /// How good it is.
    pub quality: FrameQuality,
    /// What ran for it; empty where the picture was held and nothing had to be drawn.
    pub passes: Vec<PassRun>,
}

/// How good a picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum FrameQuality {
    /// Quick, with loss: things move.
    Moving,
    /// Lossless and in full: things are still.
    Settled,
}

/// Runs of a pass for one cause in one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct PassRun {
    /// What was drawn.
    pub pass: Pass,
    /// Id of the light that it is of; `null` where it is of none.
    pub light: Option<u64>,
    /// Why what there was did not serve.
    pub cause: Cause,
    /// How often, in all samples and tiles of the picture.
    pub runs: u32,
}

/// A kind of pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Pass {
    /// What pixels see.
    Gbuffer,
    /// A light's shadow map.
    ShadowMap,
    /// The fill, and lights that have no layers.
    Lighting,
    /// What one light alone adds.
    Layer,
    /// Layers of some lights added up.
    Sum,
    /// The picture for a screen.
    Display,
}

/// Why a pass had to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub enum Cause {
    /// There was nothing of its kind yet.
    First,
    /// The scene is another.
    Scene,
    /// The camera moved, or the picture has another size.
    Camera,
    /// What its pixels see has changed.
    Gbuffer,
    /// A light has changed.
    Light,
    /// What there was is not fine enough, or another size.
    Resolution,
    /// What there was had to go for want of room.
    Evicted,
    /// It is not kept: it is of one picture, tile or sample.
    NotKept,
}

/// A line of the file that `bendylights serve --trace` writes: a picture that was made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
pub struct TraceLine {
    /// When its drawing began, in seconds since the server started.
    pub time: f64,
    /// Name of the session.
    pub session: String,
    /// Of what it is.
    pub what: TraceWhat,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// How good it is; stills are settled.
    pub quality: FrameQuality,
    /// Microseconds from the change, of a still from the request, to the start of the render.
    pub wait_us: u32,
    /// Microseconds of the render, without what was drawn for others in between.
    pub render_us: u32,
    /// Microseconds of the encoding; `null` where it was not encoded, as something newer came.
    pub encode_us: Option<u32>,
    /// What ran for it.
    pub passes: Vec<PassRun>,
    /// Lines of pictures before it that are missing, as the disk was too slow for them.
    #[serde(default, skip_serializing_if = "is_none_left_out")]
    pub left_out: u64,
}

/// Of what a traced picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "type", rename_all = "camelCase")]
pub enum TraceWhat {
    /// The view of a client.
    View {
        /// The number that the session gave it.
        client: u64,
    },
    /// A picture for HTTP.
    Still {},
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands fields over so")]
fn is_none_left_out(left_out: &u64) -> bool {
    *left_out == 0
}

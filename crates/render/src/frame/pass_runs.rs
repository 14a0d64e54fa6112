//! Counts passes and their causes.

use light::LightId;

/// Number of runs of each pass since the renderer was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassCounts {
    /// Number of passes that draw the scene's triangles for the camera.
    pub gbuffer: u64,
    /// Number of passes that draw the scene's triangles for a light.
    pub shadow: u64,
    /// Number of passes over the picture that add light, one per sample. With layers, such a pass adds the fill alone.
    pub lighting: u64,
    /// Number of passes over the picture that draw the layer of one light.
    pub layers: u64,
    /// Number of passes over the picture that convert it for a screen.
    pub display: u64,
}

/// A kind of pass; [`PassCounts`] describes its extent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// G-buffer: the surface of each pixel.
    Gbuffer,
    ShadowMap,
    /// The fill, and lights without layers.
    Lighting,
    /// Layer of a light.
    Layer,
    /// Sum of layers, or of such sums.
    Sum,
    /// Picture for a screen.
    Display,
}

/// Reason why a pass ran.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// No result was cached.
    First,
    /// The scene changed, or its nodes moved.
    Scene,
    /// The camera moved, or the size of the picture changed.
    Camera,
    Gbuffer,
    Light,
    /// The cached result has a lower resolution or another size.
    Resolution,
    /// The cached result was evicted for lack of memory.
    Evicted,
    /// The result is not cached, because it belongs to one picture, tile or sample.
    NotKept,
}

/// Runs of a pass for one cause in one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassRun {
    pub pass: Pass,
    /// Light that the pass is for; `None` if the pass is for no single light.
    pub light: Option<LightId>,
    pub cause: Cause,
    pub runs: u32,
}

impl PassRun {
    /// Adds these runs to `all`. They are merged with runs of the same pass, light and cause.
    pub fn add_to(self, all: &mut Vec<Self>) {
        let same = |run: &&mut Self| (run.pass, run.light, run.cause) == (self.pass, self.light, self.cause);
        match all.iter_mut().find(same) {
            Some(run) => run.runs = run.runs.saturating_add(self.runs),
            None => all.push(self),
        }
    }
}

#[derive(Debug, Default)]
pub(crate) struct PassRuns {
    pub counts: PassCounts,
    /// Runs for the latest picture, in order. For a picture that is drawn in several slices of time, those of the
    /// latest slice.
    pub runs: Vec<PassRun>,
}

impl PassRuns {
    pub fn note(&mut self, pass: Pass, light: Option<LightId>, cause: Cause) {
        let counts = &mut self.counts;
        match pass {
            Pass::Gbuffer => counts.gbuffer += 1,
            Pass::ShadowMap => counts.shadow += 1,
            Pass::Lighting => counts.lighting += 1,
            Pass::Layer => counts.layers += 1,
            Pass::Sum => {}
            Pass::Display => counts.display += 1,
        }
        PassRun { pass, light, cause, runs: 1 }.add_to(&mut self.runs);
    }
}

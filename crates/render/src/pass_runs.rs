//! Which passes pictures came to, and why each was not spared.

use light::LightId;

/// How often each pass has run since the renderer was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PassCounts {
    /// Over the scene's triangles for the camera.
    pub gbuffer: u64,
    /// Over the scene's triangles for a light.
    pub shadow: u64,
    /// Over the picture, once a sample: the fill and all lights; or the fill alone, where lights have layers of their own.
    pub lighting: u64,
    /// Over the picture, for one light alone.
    pub layers: u64,
    /// Over the picture, for a screen.
    pub display: u64,
}

/// A kind of pass; [`PassCounts`] says over what it runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pass {
    /// What pixels see.
    Gbuffer,
    /// A light's shadow map.
    ShadowMap,
    /// The fill, and lights that have no layers.
    Lighting,
    /// What one light alone adds.
    Layer,
    /// Layers of some lights, or sums of those, added up.
    Sum,
    /// The picture for a screen.
    Display,
}

/// Why a pass had to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// There was nothing of its kind yet.
    First,
    /// The scene is another, or its nodes lie elsewhere.
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

/// Runs of a pass for one cause in one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PassRun {
    /// What was drawn.
    pub pass: Pass,
    /// For which light, where it is for one.
    pub light: Option<LightId>,
    /// Why what there was did not serve.
    pub cause: Cause,
    /// How often.
    pub runs: u32,
}

impl PassRun {
    /// Counts these runs among `all`, with those of the same pass, light and cause.
    pub fn add_to(self, all: &mut Vec<Self>) {
        let same = |run: &&mut Self| (run.pass, run.light, run.cause) == (self.pass, self.light, self.cause);
        match all.iter_mut().find(same) {
            Some(run) => run.runs = run.runs.saturating_add(self.runs),
            None => all.push(self),
        }
    }
}

/// What has run.
#[derive(Debug, Default)]
pub(crate) struct PassRuns {
    pub counts: PassCounts,
    /// Of the latest picture or turn, in their order.
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

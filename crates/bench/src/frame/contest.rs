//! Measures lights of this renderer and other renderers, side by side.

use light::parameters::INTENSITY;
use light::{LightError, bend_with_length};
use render::{Culling, Renderer, ShadowSettings, StageCost};
use scene::{MapScale, View};
use serde::Serialize;

use super::costs::Costs;
use super::side::timed;
use super::subject::{FrameRequest, FrameSubject, crowd, instance, moved};
use super::{Bench, FrameBenchOptions};
use crate::peers::{FEWEST_FRAMES, Peer, RUNS};
use crate::{BenchError, Peers, Quantiles};

/// Times of whole frames of one renderer under one kind of light.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ComparedRenderer {
    /// Name. Variants of this renderer are `bent`, `bentHalfMap` (half the texels per side of its shadow map), `spot`,
    /// `straightBendy` (the spotlight as a BendyLight, drawn like a bent one), `bentNothingCulled` (without culling),
    /// `bentIntensity`, and a crowd of bent lights of which one moves. Other renderers have the name that they print.
    /// One light moves in each frame unless the name says otherwise. If the measured backend is not wgpu, some variants
    /// are drawn by wgpu too: `bentByWgpu` and so on.
    pub what: String,
    /// Backend of a variant of this renderer; `None` for other renderers.
    pub backend: Option<&'static str>,
    /// Version of another renderer; `None` for this one.
    pub version: Option<String>,
    /// Milliseconds per frame. For another renderer, quantiles of the medians of its rounds: the fastest single frame
    /// is not used, because nothing may have moved in it.
    pub wall_ms: Quantiles,
    /// CPU milliseconds per frame of the process on all cores; `None` for other renderers.
    pub cpu_ms: Option<Quantiles>,
    /// Ratio of the wall time to that of `bent` by the measured backend, for each quantile.
    pub to_bent: Quantiles,
}

/// Variant of this renderer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OwnVariant {
    Bent,
    BentHalfMap,
    Spot,
    StraightBendy,
    BentNothingCulled,
    BentIntensity,
    Crowd(usize),
}

/// Renderer and times of a variant.
struct MeasuredVariant {
    what: String,
    backend: &'static str,
    ours: OwnVariant,
    renderer: Renderer,
    costs: Vec<StageCost>,
}

impl OwnVariant {
    fn all(crowd: usize) -> [Self; 7] {
        [
            Self::Bent,
            Self::BentHalfMap,
            Self::Spot,
            Self::StraightBendy,
            Self::BentNothingCulled,
            Self::BentIntensity,
            Self::Crowd(crowd),
        ]
    }

    /// True if wgpu draws the variant too, if the measured backend is another.
    fn is_drawn_by_wgpu_too(self) -> bool {
        !matches!(self, Self::StraightBendy | Self::BentNothingCulled)
    }

    fn name(self) -> String {
        match self {
            Self::Bent => "bent".into(),
            Self::BentHalfMap => "bentHalfMap".into(),
            Self::Spot => "spot".into(),
            Self::StraightBendy => "straightBendy".into(),
            Self::BentNothingCulled => "bentNothingCulled".into(),
            Self::BentIntensity => "bentIntensity".into(),
            Self::Crowd(count) => format!("bent{count}OneMoves"),
        }
    }

    fn settings(self) -> ShadowSettings {
        let usual = ShadowSettings::default();
        match self {
            // The renderer would draw a BendyLight that is still straight as a spotlight.
            Self::StraightBendy => ShadowSettings { straighten: false, ..usual },
            Self::BentNothingCulled => ShadowSettings { culling: Culling::NONE, ..usual },
            _ => usual,
        }
    }

    fn frame(self, subject: &FrameSubject, k: usize) -> Result<FrameRequest, LightError> {
        let radius = subject.step();
        match self {
            Self::Bent | Self::BentNothingCulled => subject.under(moved(&subject.bent, k, radius)),
            Self::BentHalfMap => {
                let FrameRequest { view, lights } = subject.under(moved(&subject.bent, k, radius))?;
                Ok(FrameRequest { view: View { shadow_map: MapScale::Half, ..view }, lights })
            }
            Self::Spot => subject.under(moved(&subject.spot, k, radius)),
            Self::StraightBendy => {
                let segments = subject.bent.points().len().saturating_sub(2);
                let length = subject.bent.points().last().map_or(1.0, |point| point.position.length());
                let straight = bend_with_length(&subject.spot, segments, length * subject.bent.transform().scale)?;
                subject.under(moved(&straight, k, radius))
            }
            Self::BentIntensity => {
                let intensity = subject.bent.get(INTENSITY) * (1.0 + 0.01 * k as f64);
                subject.under(subject.bent.clone().with(INTENSITY, intensity))
            }
            Self::Crowd(count) => {
                let mut lights = crowd(&subject.bent, count, subject.posed.bounds().center);
                lights[0] = moved(&lights[0], k, radius);
                let lights = (0..).zip(lights).map(|(id, light)| instance(id, light));
                Ok(FrameRequest { view: subject.view.clone(), lights: lights.collect::<Result<_, _>>()? })
            }
        }
    }
}

/// Returns the number of steps of progress. All renderers are measured once in each round, and there are as many rounds
/// as other renderers have runs.
pub(super) fn steps(options: &FrameBenchOptions) -> usize {
    RUNS * (1 + options.peers.map_or(0, Peers::count))
}

/// Draws some frames in a row of each variant, as in a drag and as other renderers draw them, then runs each other
/// renderer, and repeats all of it.
pub(super) fn measured(bench: &mut Bench, subject: &FrameSubject) -> Result<Vec<ComparedRenderer>, BenchError> {
    let FrameBenchOptions { repeats, peers, .. } = bench.options;
    let mut entries = entries(bench, subject)?;
    let mut lines = Vec::new();
    let frames = repeats.div_ceil(RUNS);
    for round in 0..RUNS {
        bench.step("side by side: ours");
        for MeasuredVariant { ours, renderer, costs, .. } in &mut entries {
            // The first frame fills the caches and is not timed.
            for k in 0..=frames {
                let frame = ours.frame(subject, round * (frames + 1) + k)?;
                let cost = timed(renderer, &frame)?.1;
                if k > 0 {
                    costs.push(cost);
                }
            }
        }
        if let Some(peers) = peers {
            let frames = frames.max(FEWEST_FRAMES);
            lines.extend(peers.run_all(frames, || bench.step("side by side: peers"))?);
        }
    }
    let mut contestants: Vec<ComparedRenderer> = entries.into_iter().map(ComparedRenderer::from).collect();
    for side in &bench.backends {
        side.renderer.free_dropped_memory();
    }
    contestants.extend(Peer::all(&lines).into_iter().map(ComparedRenderer::from));
    let bent = contestants[0].wall_ms;
    for ComparedRenderer { wall_ms, to_bent, .. } in &mut contestants {
        *to_bent = wall_ms.over(&bent);
    }
    Ok(contestants)
}

/// Makes all variants for the measured backend, and some for wgpu if that is another. Each has its own cache of maps.
fn entries(bench: &Bench, subject: &FrameSubject) -> Result<Vec<MeasuredVariant>, BenchError> {
    let crowd = bench.options.crowd;
    let mut entries = Vec::new();
    for (index, side) in bench.backends.iter().enumerate() {
        let is_main = index == 0;
        let is_drawn = |ours: &OwnVariant| is_main || ours.is_drawn_by_wgpu_too();
        for ours in OwnVariant::all(crowd).into_iter().filter(is_drawn) {
            let mut renderer = side.renderer.with_same_pipelines()?;
            renderer.set_shadow_settings(ours.settings())?;
            renderer.set_scene(&subject.posed)?;
            let what = if is_main { ours.name() } else { format!("{}ByWgpu", ours.name()) };
            entries.push(MeasuredVariant { what, backend: side.backend(), ours, renderer, costs: Vec::new() });
        }
    }
    Ok(entries)
}

impl From<Peer> for ComparedRenderer {
    fn from(Peer { name, version, wall_ms }: Peer) -> Self {
        let to_bent = Quantiles::default();
        Self { what: name, backend: None, version: Some(version), wall_ms, cpu_ms: None, to_bent }
    }
}

impl From<MeasuredVariant> for ComparedRenderer {
    fn from(MeasuredVariant { what, backend, costs, .. }: MeasuredVariant) -> Self {
        let (Costs { wall_ms, cpu_ms }, to_bent) = (Costs::of(&costs), Quantiles::default());
        Self { what, backend: Some(backend), version: None, wall_ms, cpu_ms: Some(cpu_ms), to_bent }
    }
}

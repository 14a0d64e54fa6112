//! Measures run time and error of bent shadows, over resolution, edge splitting, filter and caster simplification, in
//! scenes that are difficult for shadow maps in different ways.

mod chart;
pub(crate) mod scenes;

use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use render::{Device, FrameStage, Gpu, Recording, Renderer, ShadowFilter, ShadowSettings};
use serde::Serialize;

use crate::compare::{Comparison, ComparisonSubject, ExpectedPicture, RenderedSubject};
use crate::{BenchError, Progress};

/// Texels per side of a map.
const RESOLUTIONS: [u32; 5] = [256, 512, 1024, 2048, 4096];
/// Allowed errors of a bent edge in texels; the last one splits no edges.
const EDGE_ERRORS: [Option<f32>; 7] = [Some(4.0), Some(2.0), Some(1.0), Some(0.4), Some(0.2), Some(0.1), None];
/// Allowed distances of simplified casters from the surface, as shares of the diagonal of the scene's bounds.
const MESH_ERRORS: [f64; 4] = [0.0, 1e-4, 1e-3, 1e-2];
/// Number of timings of each picture. The fastest counts, since only other work makes one slower.
const TIMINGS: usize = 7;

/// Stages that make a shadow map.
const SHADOW: [FrameStage; 6] = [
    FrameStage::Vertices,
    FrameStage::Triangles,
    FrameStage::Clip,
    FrameStage::Split,
    FrameStage::Draw,
    FrameStage::Counts,
];

/// Results of the benchmark of bent shadows.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ShadowBenchReport {
    /// Driver and device.
    pub adapter: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Results by scene, each with the same runs.
    pub scenes: Vec<SceneReport>,
}

/// Results for one scene.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SceneReport {
    /// Name of the scene.
    pub scene: String,
    /// Seconds that the reference took.
    pub reference_seconds: f64,
    /// Runs, each of which changes one setting.
    pub runs: Vec<ShadowRun>,
}

/// Time and error of one combination of settings.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ShadowRun {
    /// Texels per side of the map.
    pub resolution: u32,
    /// Allowed error of a bent edge in texels; null splits none.
    pub edge_error_texels: Option<f32>,
    /// `nearest`, `bilinear` or `pcf3x3`.
    pub filter: &'static str,
    /// Allowed distance of simplified casters from the surface, in world units.
    pub mesh_error: f64,
    /// Times in milliseconds, with empty caches.
    pub stages: ShadowCosts,
    /// Error against the reference.
    pub error: Comparison,
    /// Settings with the four values above.
    #[serde(skip)]
    pub settings: ShadowSettings,
}

/// Times of a picture's stages in milliseconds, each the minimum of several timings.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct ShadowCosts {
    /// Time of the G-buffer.
    pub gbuffer_ms: f64,
    /// Time of the shadow map.
    pub shadow_ms: f64,
    /// Time of the lighting pass, including shadow lookups.
    pub lighting_ms: f64,
}

/// Returns the settings of every run for a scene of the given diagonal: the defaults, and changes of one setting at a
/// time.
fn all_settings(diagonal: f64) -> Vec<ShadowSettings> {
    let default = ShadowSettings::default();
    let mut all: Vec<_> = RESOLUTIONS.map(|resolution| ShadowSettings { resolution, ..default }).to_vec();
    all.extend(EDGE_ERRORS.map(|edge_error_texels| ShadowSettings { edge_error_texels, ..default }));
    all.extend(ShadowFilter::ALL.map(|filter| ShadowSettings { filter, ..default }));
    all.extend(MESH_ERRORS.map(|share| ShadowSettings { mesh_error: share * diagonal, ..default }));
    let mut unique: Vec<ShadowSettings> = Vec::new();
    for settings in all {
        if !unique.contains(&settings) {
            unique.push(settings);
        }
    }
    unique
}

/// Renders every scene in `width` x `height` pixels, once with the reference and with all settings on the GPU. Saves a
/// picture of each run's differences in the existing folder `pictures`. Returns the report and the chart in SVG.
pub fn run(
    gpu: &Arc<Gpu>,
    [width, height]: [u32; 2],
    pictures: Option<&Path>,
    progress: impl Fn(Progress) + Sync,
) -> Result<(ShadowBenchReport, String), BenchError> {
    let mut renderer = Renderer::new(&Device::Wgpu(Arc::clone(gpu)))?;
    let subjects = scenes::subjects(width, height);
    // Every scene has the same number of runs; the reference's picture is one step more.
    let steps = all_settings(1.0).len() + 1;
    let mut scenes = Vec::with_capacity(subjects.len());
    for (index, subject) in subjects.iter().enumerate() {
        let step = |done: usize| {
            progress(Progress { done: index * steps + done, of: subjects.len() * steps, what: subject.name.clone() });
        };
        scenes.push(run_scene(&mut renderer, subject, pictures, step)?);
    }
    let report = ShadowBenchReport { adapter: gpu.adapter_name().into(), width, height, scenes };
    let chart = chart::draw(&report)?;
    Ok((report, chart))
}

fn run_scene(
    renderer: &mut Renderer,
    subject: &ComparisonSubject,
    pictures: Option<&Path>,
    step: impl Fn(usize),
) -> Result<SceneReport, BenchError> {
    step(0);
    let start = Instant::now();
    let expected = ExpectedPicture::new(subject, || {})?;
    let reference_seconds = start.elapsed().as_secs_f64();
    renderer.set_scene(expected.posed())?;
    let diagonal = 2.0 * expected.posed().half_extent.length();
    let mut runs = Vec::new();
    for (index, shadows) in all_settings(diagonal).into_iter().enumerate() {
        step(1 + index);
        let drawn = RenderedSubject::new(renderer, subject, shadows)?;
        let error = expected.compare(&drawn);
        let run = ShadowRun {
            resolution: shadows.resolution,
            edge_error_texels: shadows.edge_error_texels,
            filter: name(shadows.filter),
            mesh_error: shadows.mesh_error,
            stages: time(renderer, subject)?,
            error,
            settings: shadows,
        };
        if let Some(folder) = pictures {
            expected.panels(&drawn, &run.error).save(folder.join(run.file_name(&subject.name)))?;
        }
        runs.push(run);
    }
    Ok(SceneReport { scene: subject.name.clone(), reference_seconds, runs })
}

/// Measures the stages of the picture.
fn time(renderer: &mut Renderer, subject: &ComparisonSubject) -> Result<ShadowCosts, BenchError> {
    let lights = subject.lights()?;
    let mut record = || {
        renderer.invalidate();
        renderer.record_display(&subject.view, &lights).map(|(_, recording)| recording)
    };
    let recordings = (0..TIMINGS).map(|_| record()).collect::<Result<Vec<_>, _>>()?;
    let fastest = |stages: &[FrameStage]| {
        let sum = |recording: &Recording| stages.iter().map(|stage| recording.cost(*stage).wall_ms).sum::<f64>();
        recordings.iter().map(sum).fold(f64::INFINITY, f64::min)
    };
    Ok(ShadowCosts {
        gbuffer_ms: fastest(&[FrameStage::Gbuffer]),
        shadow_ms: fastest(&SHADOW),
        lighting_ms: fastest(&[FrameStage::Fill, FrameStage::Light]),
    })
}

fn name(filter: ShadowFilter) -> &'static str {
    match filter {
        ShadowFilter::Nearest => "nearest",
        ShadowFilter::Bilinear => "bilinear",
        ShadowFilter::Pcf3x3 => "pcf3x3",
    }
}

impl ShadowRun {
    fn file_name(&self, scene: &str) -> String {
        let edge = self.edge_error_texels.map_or("unsplit".into(), |texels| format!("{texels}"));
        format!("{scene}-{}-{edge}-{}-{}.png", self.resolution, self.filter, self.mesh())
    }

    /// Returns the short text of the mesh error.
    fn mesh(&self) -> String {
        if self.mesh_error == 0.0 { "exact".into() } else { format!("{:.1e}", self.mesh_error) }
    }
}

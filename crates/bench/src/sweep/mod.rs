//! Measures the correctness of pictures in random poses: lights of each shape with random orientation, over objects on
//! floors of every size, between walls, in rooms and under roofs. Each backend draws them, and the reference judges
//! them.
//!
//! A pixel is judged if the reference is constant within 1.5 texels of it. No part of the measure uses the shadow map.

mod chart;
mod close;
mod judge;
mod picture;
mod pose;
mod stage;

use std::path::PathBuf;
use std::time::Instant;

use fastrand::Rng;
use glam::{DVec2, DVec3, UVec2};
use light::parameters::CONE_ANGLE;
use light::{CheckedLight, Light, LightInstance, ParameterOwner};
use reference::{LinkedReferenceLight, ReferenceLight, ShadedPoint};
use render::{Backend, Device, Host, Renderer, ShadowSettings};
use scene::{Aov, Camera, Scene, View};
use serde::Serialize;

use crate::{BenchError, Progress};
use judge::JudgedView;
use stage::{Surroundings, SweepStage};

/// Backends that are compared, in the order of reports.
pub const BACKENDS: [Backend; 2] = [Backend::Wgpu, Backend::Native];
/// Shapes of lights by their names in JSON, in the order of reports.
pub const SHAPES: [(&str, ParameterOwner); 4] = [
    ("directional", ParameterOwner::Directional),
    ("omni", ParameterOwner::Omni),
    ("spot", ParameterOwner::Spot),
    ("bendy", ParameterOwner::Bendy),
];

/// Visibility error above which a pixel is wrong: weights of a filter add up to 1 within some ulps.
const WRONG: f32 = 1e-3;
/// Minimum share of stable pixels among those that see a surface. A pose with less counts as failed.
const MIN_STABLE_SHARE: f64 = 0.5;

/// Least share of the visible surfaces that a light must contain to be used, tested at one of `LATTICE` pixels along
/// each axis. After `TRIES` lights the last is used.
const MIN_SHARE_IN_LIGHT: f64 = 0.3;
const LATTICE: u32 = 4;
const TRIES: usize = 60;
/// Share of poses that are close-ups.
const CLOSE_UP_SHARE: f64 = 0.5;
/// Factors of the distance of a close-up, tried in order until enough pixels are stable.
const CLOSE_UP_DISTANCE_FACTORS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];

/// Scene from a file that is used in addition to the random ones.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// Name in reports.
    pub name: String,
    /// The fill is not used.
    pub scene: Scene,
    /// The view has the first camera; without cameras it frames the scene.
    pub cameras: Vec<Camera>,
}

/// Options of a sweep.
#[derive(Clone, Debug)]
pub struct SweepOptions {
    /// Numbers of the poses to draw, for each shape.
    pub poses: Vec<usize>,
    /// Seed of the random poses.
    pub seed: u64,
    /// Pixels of each picture.
    pub size: [u32; 2],
    /// Shapes of lights, from [`SHAPES`].
    pub shapes: Vec<&'static str>,
    /// Scenes in addition to the random ones.
    pub scenes: Vec<SceneFile>,
    /// Texels per side of shadow maps.
    pub resolution: u32,
    /// Existing folder for a picture of each pose with a wrong pixel.
    pub pictures: Option<PathBuf>,
}

/// Results of a sweep.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SweepReport {
    /// Driver and device.
    pub adapter: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Seed of the random poses.
    pub seed: u64,
    /// Texels per side of shadow maps.
    pub resolution: u32,
    /// One row per shape and backend.
    pub rows: Vec<SweepRow>,
    /// Poses that failed or have wrong pixels.
    pub faults: Vec<SweepPose>,
    #[serde(skip)]
    pub poses: Vec<SweepPose>,
}

/// Results of one shape of light with one backend.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SweepRow {
    /// Name of the shape in JSON.
    pub shape: &'static str,
    /// `wgpu` or `native`.
    pub backend: &'static str,
    /// Number of poses drawn.
    pub poses: usize,
    /// Poses with fewer than half of the pixels with a surface stable: they are not judged.
    pub failed: usize,
    /// Number of stable pixels, which are judged. They see a surface, and the reference is constant within 1.5 texels
    /// around.
    pub stable: usize,
    /// Stable pixels with a wrong shadow, after the reference tested 900 points around each.
    pub wrong: usize,
    /// Poses with at least one wrong pixel.
    pub poses_wrong: usize,
    /// Maximum of wrong pixels in a pose.
    pub worst: usize,
    /// Median over poses of the relative RMSE of radiance over stable pixels that are not wrong.
    pub radiance_rmse_p50: f64,
    /// Maximum over poses of that RMSE.
    pub radiance_rmse_max: f64,
    /// Median over poses of the milliseconds from a moved light to its picture.
    pub frame_ms_p50: f64,
}

/// A pose of a light over a stage, and its results.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SweepPose {
    /// Name of the shape in JSON.
    pub shape: &'static str,
    /// Number of the pose. With the seed and the shape it reproduces the pose.
    pub pose: usize,
    /// Name of the stage.
    pub stage: String,
    /// True for a close-up: pixels are about as wide as texels, on an edge between surfaces near a shadow.
    pub is_close: bool,
    /// Pixels that see a surface.
    pub surfaces: usize,
    /// Stable pixels, which are judged.
    pub stable: usize,
    /// The largest `R kappa` of a bent light; `None` for other shapes.
    pub r_kappa: Option<f64>,
    /// Results by backend.
    pub by: Vec<PoseResult>,
}

/// Results of a backend's picture of a pose.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PoseResult {
    /// `wgpu` or `native`.
    pub backend: &'static str,
    /// Stable pixels with a wrong shadow.
    pub wrong: usize,
    /// Relative RMSE of radiance over the stable pixels that have no wrong shadow.
    pub radiance_rmse: f64,
    /// Milliseconds of the picture, with a new light.
    pub frame_ms: f64,
}

/// Draws random poses of each shape of light with both backends, and compares the shadows with the reference. Returns
/// the report and the chart in SVG.
pub fn run(options: &SweepOptions, progress: impl Fn(Progress)) -> Result<(SweepReport, String), BenchError> {
    let open = |backend| Ok(Device::open(Host::default(), Some(backend))?);
    let devices = BACKENDS.into_iter().map(open).collect::<Result<Vec<_>, BenchError>>()?;
    let mut renderers: Vec<Renderer> = devices.iter().map(Renderer::new).collect::<Result<_, _>>()?;
    let report = sweep(&mut renderers, &devices[0].name(), options, progress)?;
    let chart = chart::draw(&report)?;
    Ok((report, chart))
}

/// Does the work of `run` with the given renderers, which are in the order of [`BACKENDS`].
pub fn sweep(
    renderers: &mut [Renderer],
    adapter: &str,
    options: &SweepOptions,
    progress: impl Fn(Progress),
) -> Result<SweepReport, BenchError> {
    let [width, height] = options.size;
    let of = options.poses.len() * options.shapes.len();
    let aspect_ratio = f64::from(width) / f64::from(height);
    let stage = |file: &SceneFile| SweepStage::of_file(&file.name, file.scene.clone(), &file.cameras, aspect_ratio);
    let files: Vec<SweepStage> = options.scenes.iter().map(stage).collect();
    for renderer in renderers.iter_mut() {
        renderer.set_shadow_settings(ShadowSettings { resolution: options.resolution, ..ShadowSettings::default() })?;
    }
    let (mut poses, mut wrong) = (Vec::with_capacity(of), 0);
    let shapes = SHAPES.into_iter().filter(|(name, _)| options.shapes.contains(name));
    for (name, shape) in shapes.clone() {
        for &number in &options.poses {
            let pose = measure_pose(renderers, name, shape, number, &files, options)?;
            wrong += pose.by.iter().map(|drawn| drawn.wrong).sum::<usize>();
            poses.push(pose);
            progress(Progress { done: poses.len(), of, what: format!("{wrong} pixels wrong") });
        }
    }
    let rows = shapes.flat_map(|(name, _)| {
        let of_shape: Vec<&SweepPose> = poses.iter().filter(|pose| pose.shape == name).collect();
        (0..renderers.len()).map(move |index| row(&of_shape, index))
    });
    Ok(SweepReport {
        adapter: adapter.into(),
        width,
        height,
        seed: options.seed,
        resolution: options.resolution,
        rows: rows.collect(),
        faults: poses.iter().filter(|pose| !pose.is_right()).cloned().collect(),
        poses,
    })
}

/// Returns a random number generator of a pose, independent of the other options.
fn rng(seed: u64, shape: ParameterOwner, number: usize) -> Rng {
    let mut rng = Rng::with_seed(seed ^ (shape as u64) << 56 ^ (number as u64) << 32);
    // The first numbers of similar seeds are similar.
    (0..8).for_each(|_| {
        rng.u64(..);
    });
    rng
}

fn measure_pose(
    renderers: &mut [Renderer],
    name: &'static str,
    shape: ParameterOwner,
    number: usize,
    files: &[SweepStage],
    options: &SweepOptions,
) -> Result<SweepPose, BenchError> {
    let rng = &mut rng(options.seed, shape, number);
    let made;
    let kind = number % (Surroundings::ALL.len() + files.len());
    let stage = match Surroundings::ALL.get(kind) {
        Some(setting) => {
            made = SweepStage::random(*setting, rng);
            &made
        }
        None => &files[kind - Surroundings::ALL.len()],
    };
    let whole = View { samples: 1, ..View::beauty(stage.camera.clone(), options.size) };
    let light = random_visible_light(shape, stage, &whole, rng);
    let lights = LightInstance::numbered([light.clone()])?;
    let source = ReferenceLight::new(&lights[0].light);
    let texel = |surface: &ShadedPoint| texel(&source, &light, stage, surface, options.resolution);
    let is_close = rng.f64() < CLOSE_UP_SHARE;
    let corner = is_close.then(|| close::find(&stage.reference, &source, &whole, texel, rng)).flatten();
    let judged = |camera: Camera| {
        let view = View { camera, ..whole.clone() };
        let judged = judge::judge(&stage.reference, &source, &view, texel);
        (view, judged)
    };
    let (view, judged) = match corner {
        Some(corner) => far_enough(|times| judged(corner.camera(times))),
        None => judged(stage.camera.clone()),
    };
    let linked = [LinkedReferenceLight::new(&stage.reference.bvh.posed, &lights[0].light)];
    let radiance = |surface: &ShadedPoint| stage.reference.radiance(&linked, 0.0, surface);
    let expected: Vec<DVec3> = judged.stable.iter().map(|stable| radiance(&stable.surface)).collect();
    let mut by = Vec::with_capacity(renderers.len());
    let mut shown = Vec::new();
    for (renderer, backend) in renderers.iter_mut().zip(BACKENDS) {
        renderer.set_scene(&stage.reference.bvh.posed)?;
        let begun = Instant::now();
        let beauty = renderer.render(&view, &lights)?;
        let frame_ms = begun.elapsed().as_secs_f64() * 1e3;
        let visibility = renderer.render(&View { aov: Aov::Visibility, ..view.clone() }, &lights)?;
        let is_off = |stable: &judge::StablePixel| {
            let [share, .., inside] = visibility.pixels[stable.pixel];
            let expected = stable.is_lit.map_or(0.0, f32::from);
            (share * inside - expected).abs() > WRONG
        };
        let (mut error2, mut expected2) = (0.0, 0.0);
        let mut wrong = Vec::new();
        for (stable, expected) in judged.stable.iter().zip(&expected) {
            if is_off(stable) {
                if judge::is_surely_stable(&stage.reference, &source, stable, texel(&stable.surface)) {
                    wrong.push(stable.pixel);
                }
                continue;
            }
            let [r, g, b, _] = beauty.pixels[stable.pixel].map(f64::from);
            error2 += (DVec3::new(r, g, b) - *expected).length_squared();
            expected2 += expected.length_squared();
        }
        let radiance_rmse = if error2 == 0.0 { 0.0 } else { (error2 / expected2).sqrt() };
        by.push(PoseResult { backend: backend.name(), wrong: wrong.len(), radiance_rmse, frame_ms });
        shown.push((beauty, wrong));
    }
    let r_kappa = match &source {
        ReferenceLight::Bendy(tube) => Some(tube.r_kappa_max().into_iter().fold(0.0, f64::max)),
        _ => None,
    };
    let pose = SweepPose {
        shape: name,
        pose: number,
        stage: stage.name.clone(),
        is_close: corner.is_some(),
        surfaces: judged.surfaces,
        stable: judged.stable.len(),
        r_kappa,
        by,
    };
    if let Some(folder) = &options.pictures
        && !pose.is_right()
    {
        let [width, height] = options.size.map(|side| side as usize);
        let radiance = |pixel: usize| {
            let centre = DVec2::new((pixel % width) as f64, (pixel / width) as f64) + 0.5;
            stage.reference.surface(&view, centre).map_or(DVec3::ZERO, |surface| radiance(&surface))
        };
        let reference: Vec<DVec3> = (0..width * height).map(radiance).collect();
        let file = folder.join(format!("{name}-{number}-{}.png", stage.name));
        picture::panels(options.size, &reference, &judged, &shown).save(file)?;
    }
    Ok(pose)
}

/// Returns the nearest close-up with enough stable pixels, or the farthest.
fn far_enough(look: impl Fn(f64) -> (View, JudgedView)) -> (View, JudgedView) {
    let [first, farther @ ..] = CLOSE_UP_DISTANCE_FACTORS;
    let mut found = look(first);
    for times in farther {
        if judge::stable_share(found.1.stable.len(), found.1.surfaces) >= MIN_STABLE_SHARE {
            break;
        }
        found = look(times);
    }
    found
}

/// Makes a random light of a shape that contains enough visible surfaces for its shadows to be judged, or the last one
/// tried.
fn random_visible_light(shape: ParameterOwner, stage: &SweepStage, view: &View, rng: &mut Rng) -> Light {
    let [columns, rows] = [view.width / LATTICE, view.height / LATTICE];
    let places = (0..columns * rows).map(|k| UVec2::new(k % columns, k / columns) * LATTICE);
    let surfaces: Vec<ShadedPoint> =
        places.filter_map(|at| stage.reference.surface(view, at.as_dvec2() + 0.5)).collect();
    let holds_enough = |light: &Light| {
        let Ok(checked) = CheckedLight::new(light.clone()) else { return false };
        let source = ReferenceLight::new(&checked);
        let inside = surfaces.iter().filter(|surface| stage.reference.sample(&source, surface).is_some());
        inside.count() as f64 >= MIN_SHARE_IN_LIGHT * surfaces.len() as f64
    };
    let mut light = pose::random(shape, stage, rng);
    for _ in 1..TRIES {
        if holds_enough(&light) {
            break;
        }
        light = pose::random(shape, stage, rng);
    }
    light
}

/// Returns the maximum width of a texel across the light at a surface, in world units: a map may be fitted more
/// tightly, never less.
fn texel(source: &ReferenceLight, light: &Light, stage: &SweepStage, surface: &ShadedPoint, resolution: u32) -> f64 {
    // A border of four texels around the fitted region is for the filter.
    let texels = |resolution: u32| f64::from(resolution) - 4.0;
    let origin = stage.reference.bvh.posed.origin_in_world;
    let away = |source_in_world: DVec3| (surface.position + origin).distance(source_in_world);
    match source {
        ReferenceLight::Directional(_) => 2.0 * stage.casters_radius / texels(resolution),
        // The faces of cube maps have half the texels per side, and slopes from -1 to 1.
        ReferenceLight::Omni(omni) => 2.0 * away(omni.translation) / texels(resolution / 2),
        ReferenceLight::Spot(cone) if light.get(CONE_ANGLE) > 60.0 => {
            2.0 * away(cone.translation) / texels(resolution / 2)
        }
        ReferenceLight::Spot(cone) => 2.0 * cone.tan_outer * away(cone.translation) / texels(resolution),
        ReferenceLight::Bendy(tube) => {
            let placement = &tube.placement;
            let root = tube.nearest_root(placement.tube_from_world(surface.position + origin));
            // Texel of the widest map that the light may have.
            root.map_or(0.0, |root| 2.0 * root.radius * placement.world_per_tube / texels(resolution))
        }
    }
}

fn row(poses: &[&SweepPose], index: usize) -> SweepRow {
    let by: Vec<&PoseResult> = poses.iter().map(|pose| &pose.by[index]).collect();
    let median = |of: &dyn Fn(&PoseResult) -> f64| {
        let mut values: Vec<f64> = by.iter().map(|drawn| of(drawn)).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    };
    SweepRow {
        shape: poses.first().map_or("", |pose| pose.shape),
        backend: by.first().map_or("", |drawn| drawn.backend),
        poses: poses.len(),
        failed: poses.iter().filter(|pose| pose.has_failed()).count(),
        stable: poses.iter().map(|pose| pose.stable).sum(),
        wrong: by.iter().map(|drawn| drawn.wrong).sum(),
        poses_wrong: by.iter().filter(|drawn| drawn.wrong > 0).count(),
        worst: by.iter().map(|drawn| drawn.wrong).max().unwrap_or(0),
        radiance_rmse_p50: median(&|drawn| drawn.radiance_rmse),
        radiance_rmse_max: by.iter().map(|drawn| drawn.radiance_rmse).fold(0.0, f64::max),
        frame_ms_p50: median(&|drawn| drawn.frame_ms),
    }
}

impl SweepPose {
    fn has_failed(&self) -> bool {
        judge::stable_share(self.stable, self.surfaces) < MIN_STABLE_SHARE
    }

    fn is_right(&self) -> bool {
        !self.has_failed() && self.by.iter().all(|drawn| drawn.wrong == 0)
    }
}

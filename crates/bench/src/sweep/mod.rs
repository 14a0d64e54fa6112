//! Is a picture right at first sight? Random lights of each shape, turned about themselves, over things on floors of every
//! size, between walls, in rooms and under roofs, drawn by each backend and held to the reference.
//!
//! A pixel is judged where the reference says the same of everything within 1.5 texels of it; nothing of the
//! measure knows the map.

mod chart;
mod close;
mod judge;
mod picture;
mod pose;
mod stage;

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use fastrand::Rng;
use glam::{DVec2, DVec3, UVec2};
use light::parameters::CONE_ANGLE;
use light::{CheckedLight, Light, LightInstance, ParameterOwner};
use reference::{LinkedReferenceLight, ReferenceLight, ShadedPoint};
use render::{Backend, Gpu, MemoryBudget, Renderer, ShadowSettings};
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

/// A pixel is wrong whose visibility is off by more: weights of a filter add up to 1 within some ulps.
const WRONG: f32 = 1e-3;
/// Less of a pose than this share of what is seen is calm, and the pose counts as failed.
const MIN_STABLE_SHARE: f64 = 0.5;

/// A light is taken where it holds at least this share of what is seen, by one pixel of so many along each axis; of so many
/// the last is taken in any case.
const MIN_SHARE_IN_LIGHT: f64 = 0.3;
const LATTICE: u32 = 4;
const TRIES: usize = 60;
/// The share of poses that are looked at from close by.
const CLOSE_UP_SHARE: f64 = 0.5;
/// Times the distance of those from which one looks where less than enough is calm.
const CLOSE_UP_DISTANCE_FACTORS: [f64; 4] = [1.0, 2.0, 4.0, 8.0];

/// A scene of a file to sweep over besides the random ones.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// Names it in reports.
    pub name: String,
    /// Its fill is not used.
    pub scene: Scene,
    /// The first is looked through; a scene without one is framed.
    pub cameras: Vec<Camera>,
}

/// What to sweep over.
#[derive(Clone, Debug)]
pub struct SweepOptions {
    /// Poses of each shape.
    pub poses: usize,
    /// The same seed makes the same poses.
    pub seed: u64,
    /// Pixels of each picture.
    pub size: [u32; 2],
    /// Shapes of lights, of [`SHAPES`].
    pub shapes: Vec<&'static str>,
    /// Scenes besides the random ones.
    pub scenes: Vec<SceneFile>,
    /// Texels along each side of shadow maps.
    pub resolution: u32,
    /// Only the pose of that number, of each shape.
    pub only: Option<usize>,
    /// Folder, there already, for a picture of each pose with a wrong pixel.
    pub pictures: Option<PathBuf>,
}

/// What a sweep found.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SweepReport {
    /// Driver and device.
    pub adapter: String,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Of the random numbers.
    pub seed: u64,
    /// Texels along each side of shadow maps.
    pub resolution: u32,
    /// A row a shape and backend.
    pub rows: Vec<SweepRow>,
    /// One a pose that is not right.
    pub faults: Vec<SweepPose>,
    /// All poses.
    #[serde(skip)]
    pub poses: Vec<SweepPose>,
}

/// A shape of light by a backend.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SweepRow {
    /// As parameters call it.
    pub shape: &'static str,
    /// `wgpu` or `native`.
    pub backend: &'static str,
    /// How many poses were drawn.
    pub poses: usize,
    /// Poses of whose surfaces less than half are calm: nothing is known of them.
    pub failed: usize,
    /// Pixels judged: a surface is seen, and the reference says the same within 1.5 texels.
    pub calm: usize,
    /// Those whose shadow is another: the reference is asked again in 900 places around each.
    pub wrong: usize,
    /// Poses with one such or more.
    pub poses_wrong: usize,
    /// The most in one pose.
    pub worst: usize,
    /// Relative RMSE of radiance over calm pixels that are not wrong: half of poses have at most this.
    pub radiance_rmse_p50: f64,
    /// The largest of a pose.
    pub radiance_rmse_max: f64,
    /// Milliseconds from a moved light to its picture, half of poses.
    pub frame_ms_p50: f64,
}

/// A pose of a light over a stage, and what became of it.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct SweepPose {
    /// As parameters call it.
    pub shape: &'static str,
    /// Its number: with the seed and the shape it makes the pose again.
    pub pose: usize,
    /// What it is over.
    pub stage: String,
    /// Whether pixels are about as wide as texels, where surfaces meet at a shadow.
    pub is_close: bool,
    /// Pixels that see a surface.
    pub surfaces: usize,
    /// Of those, judged.
    pub calm: usize,
    /// Of a bent light, the largest `R kappa`.
    pub r_kappa: Option<f64>,
    /// By each backend.
    pub by: Vec<PoseResult>,
}

/// A backend's picture of a pose.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct PoseResult {
    /// `wgpu` or `native`.
    pub backend: &'static str,
    /// Calm pixels whose shadow is another.
    pub wrong: usize,
    /// Of radiance, over the other calm pixels.
    pub radiance_rmse: f64,
    /// Milliseconds of the picture, its light new.
    pub frame_ms: f64,
}

/// Sweeps by both backends of the machine's device. Returns what was found and the chart, an SVG.
pub fn run(options: &SweepOptions, progress: impl Fn(Progress)) -> Result<(SweepReport, String), BenchError> {
    let open = |backend| Ok(Arc::new(Gpu::open(MemoryBudget::default(), Some(backend))?));
    let gpus = BACKENDS.into_iter().map(open).collect::<Result<Vec<_>, BenchError>>()?;
    let mut renderers: Vec<Renderer> =
        gpus.iter().map(|gpu| Renderer::new(Arc::clone(gpu))).collect::<Result<_, _>>()?;
    let report = sweep(&mut renderers, gpus[0].adapter_name(), options, progress)?;
    let chart = chart::draw(&report)?;
    Ok((report, chart))
}

/// Sweeps by those renderers, in the order of [`BACKENDS`].
pub fn sweep(
    renderers: &mut [Renderer],
    adapter: &str,
    options: &SweepOptions,
    progress: impl Fn(Progress),
) -> Result<SweepReport, BenchError> {
    let [width, height] = options.size;
    let numbers = options.only.map_or(0..options.poses, |only| only..only + 1);
    let of = numbers.len() * options.shapes.len();
    let files: Vec<SweepStage> = options
        .scenes
        .iter()
        .map(|file| {
            let aspect_ratio = f64::from(width) / f64::from(height);
            SweepStage::of_file(&file.name, file.scene.clone(), &file.cameras, aspect_ratio)
        })
        .collect();
    for renderer in renderers.iter_mut() {
        renderer.set_shadow_settings(ShadowSettings {
            resolution: options.resolution,
            ..ShadowSettings::default()
        })?;
    }
    let (mut poses, mut wrong) = (Vec::with_capacity(of), 0);
    let shapes = SHAPES.into_iter().filter(|(name, _)| options.shapes.contains(name));
    for shape in shapes.clone() {
        for number in numbers.clone() {
            let pose = measure_pose(renderers, shape, number, &files, options)?;
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

/// The random numbers of a pose, the same whatever else is swept over.
fn rng(seed: u64, shape: ParameterOwner, number: usize) -> Rng {
    let mut rng = Rng::with_seed(seed ^ (shape as u64) << 56 ^ (number as u64) << 32);
    // Seeds that are alike begin alike.
    (0..8).for_each(|_| {
        rng.u64(..);
    });
    rng
}

fn measure_pose(
    renderers: &mut [Renderer],
    (name, shape): (&'static str, ParameterOwner),
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
    let expected: Vec<DVec3> = judged.stable.iter().map(|calm| radiance(&calm.surface)).collect();
    let mut by = Vec::with_capacity(renderers.len());
    let mut shown = Vec::new();
    for (renderer, backend) in renderers.iter_mut().zip(BACKENDS) {
        renderer.set_scene(&stage.reference.bvh.posed)?;
        let begun = Instant::now();
        let beauty = renderer.render(&view, &lights)?;
        let frame_ms = begun.elapsed().as_secs_f64() * 1e3;
        let visibility = renderer.render(&View { aov: Aov::Visibility, ..view.clone() }, &lights)?;
        let is_off = |calm: &judge::StablePixel| {
            let [share, .., inside] = visibility.pixels[calm.pixel];
            let expected = calm.is_lit.map_or(0.0, f32::from);
            (share * inside - expected).abs() > WRONG
        };
        let (mut error2, mut expected2) = (0.0, 0.0);
        let mut wrong = Vec::new();
        for (calm, expected) in judged.stable.iter().zip(&expected) {
            if is_off(calm) {
                if judge::is_surely_stable(&stage.reference, &source, calm, texel(&calm.surface)) {
                    wrong.push(calm.pixel);
                }
                continue;
            }
            let [r, g, b, _] = beauty.pixels[calm.pixel].map(f64::from);
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
        calm: judged.stable.len(),
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

/// The first look from farther and farther of which enough is calm, or the farthest.
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

/// A random light of a shape that holds enough of what is seen for its shadows to be judged, or the last that was tried.
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

/// The width of a texel across the light at a surface, in world units, at most: maps may be fitted to less, never to more.
fn texel(
    source: &ReferenceLight,
    light: &Light,
    stage: &SweepStage,
    surface: &ShadedPoint,
    resolution: u32,
) -> f64 {
    // Four texels around what is fitted to are room for the filter.
    let texels = |resolution: u32| f64::from(resolution) - 4.0;
    let origin = stage.reference.bvh.posed.origin_in_world;
    let away = |source_in_world: DVec3| (surface.position + origin).distance(source_in_world);
    match source {
        ReferenceLight::Directional(_) => 2.0 * stage.casters_radius / texels(resolution),
        // The faces of cubes have half the texels a side, and slopes from -1 to 1.
        ReferenceLight::Omni(omni) => 2.0 * away(omni.translation) / texels(resolution / 2),
        ReferenceLight::Spot(cone) if light.get(CONE_ANGLE) > 60.0 => {
            2.0 * away(cone.translation) / texels(resolution / 2)
        }
        ReferenceLight::Spot(cone) => 2.0 * cone.tan_outer * away(cone.translation) / texels(resolution),
        ReferenceLight::Bendy(tube) => {
            let placement = &tube.placement;
            let root = tube.nearest_root(placement.tube_from_world(surface.position + origin));
            // Of the widest map that it may have.
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
        calm: poses.iter().map(|pose| pose.calm).sum(),
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
        judge::stable_share(self.calm, self.surfaces) < MIN_STABLE_SHARE
    }

    fn is_right(&self) -> bool {
        !self.has_failed() && self.by.iter().all(|drawn| drawn.wrong == 0)
    }
}

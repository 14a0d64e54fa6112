//! Measures growth of frame times with scene, lights and picture size. Each point has its error against the reference.

use glam::{DQuat, DVec3};
use light::parameters::{CONE_ANGLE, INTENSITY, ROTATION, TRANSLATION};
use light::{Light, LightInstance};
use render::{ShadowSettings, StageCost};
use scene::{Scene, View, ViewSlot};
use serde::Serialize;

use super::Bench;
use super::costs::{Costs, WorkCounts};
use super::error::{self, PictureError, REFERENCE_DIVISOR};
use super::side::timed;
use super::subject::{FrameRequest, crowd, instance, moved};
use crate::BenchError;
use crate::bent::bent;
use crate::shadow::scenes::{floor, grey_scene, place, view};
use crate::solids::{PlacedPrimitive, ball};

/// Balls along each side of the square that they form.
const SIDE: u32 = 5;
/// Triangles inside the tube, on axes that count other things.
const INSIDE: u32 = 10_000;
/// Distance between the balls in the light and those that it does not reach, in world units.
const OUTSIDE: f64 = 5.0;
/// Pixels of a frame, on axes that count other things.
const SIZE: [u32; 2] = [686, 382];
/// Divisor of each side of a picture that is compared with the reference, on the axis of picture sizes.
const REFERENCE_DIVISOR_FOR_PIXELS: u32 = 8;
/// Half angle of the light's cone in degrees: its circle on the floor is larger than the square of the balls.
const CONE: f64 = 26.0;
/// Radius of the circle in which the light moves, in world units.
const RADIUS: f64 = 0.05;

/// Amounts of each quantity for which frames are measured.
#[derive(Clone, Debug)]
pub struct GrowthPlan {
    /// Numbers of triangles, inside the tube and outside of it.
    pub triangles: Vec<u32>,
    /// Numbers of lights, of which one moves.
    pub lights: Vec<usize>,
    /// Numbers of segments of the light.
    pub segments: Vec<usize>,
    /// Widths and heights in pixels.
    pub sizes: Vec<[u32; 2]>,
}

/// Frames that differ in one quantity. The light moves in each.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct GrowthAxis {
    /// `trianglesInTube`, `trianglesOutside`, `lights`, `segments` or `pixels`.
    pub axis: &'static str,
    /// Measurements, one for each amount of the quantity, in ascending order.
    pub points: Vec<GrowthPoint>,
}

/// Measurements at one amount of the quantity that an axis varies.
#[derive(Clone, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct GrowthPoint {
    /// Amount of the quantity, such as a number of triangles.
    pub value: u64,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// Costs of the measured backend.
    #[serde(flatten)]
    pub grown: GrowthCosts,
    /// Costs of wgpu, measured in rotation with the measured backend. `None` if the measured backend is wgpu.
    pub by_wgpu: Option<GrowthCosts>,
}

/// Costs and error of a backend's frames at one amount of the quantity that an axis varies.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct GrowthCosts {
    /// Costs of a whole frame.
    pub frame: Costs,
    #[serde(flatten)]
    pub counted: WorkCounts,
    /// Error of a smaller picture of the frame.
    pub error: PictureError,
}

impl GrowthPlan {
    /// Returns the plan of the benchmark: each axis from amounts that are small today to large ones.
    pub fn full() -> Self {
        Self {
            triangles: vec![10_000, 30_000, 100_000, 300_000, 1_000_000],
            lights: vec![1, 4, 16, 64],
            segments: vec![1, 2, 3, 4, 6, 8, 12, 16],
            sizes: vec![[640, 360], [1280, 720], [1920, 1080], [3840, 2160]],
        }
    }

    /// Returns the number of steps that the progress report counts.
    pub(super) fn steps(&self) -> usize {
        2 * self.triangles.len() + self.lights.len() + self.segments.len() + self.sizes.len()
    }
}

/// Scene, lights and picture size of one measurement.
struct GrowthSetting {
    value: u64,
    scene: Scene,
    lights: Vec<Light>,
    size: [u32; 2],
    reference_divisor: u32,
}

/// Measures every axis.
pub(super) fn measured(bench: &mut Bench, plan: &GrowthPlan) -> Result<Vec<GrowthAxis>, BenchError> {
    let alone = |segments| Ok::<_, BenchError>(vec![bent(&spot(), segments, length())?]);
    let setting =
        |value, scene, lights| GrowthSetting { value, scene, lights, size: SIZE, reference_divisor: REFERENCE_DIVISOR };
    let mut axes: [(&'static str, Vec<GrowthSetting>); 5] =
        ["trianglesInTube", "trianglesOutside", "lights", "segments", "pixels"].map(|axis| (axis, Vec::new()));
    for &triangles in &plan.triangles {
        let value = u64::from(triangles);
        axes[0].1.push(setting(value, balls(triangles, 0), alone(3)?));
        axes[1].1.push(setting(value, balls(INSIDE, triangles), alone(3)?));
    }
    for &count in &plan.lights {
        let lights = crowd(&bent(&spot(), 3, length())?, count, DVec3::ZERO);
        axes[2].1.push(setting(count as u64, balls(INSIDE, 0), lights));
    }
    for &segments in &plan.segments {
        axes[3].1.push(setting(segments as u64, balls(INSIDE, 0), alone(segments)?));
    }
    for &size in &plan.sizes {
        let value = u64::from(size[0]) * u64::from(size[1]);
        let setting = setting(value, balls(INSIDE, 0), alone(3)?);
        axes[4].1.push(GrowthSetting { size, reference_divisor: REFERENCE_DIVISOR_FOR_PIXELS, ..setting });
    }
    let axis = |(axis, settings): (&'static str, Vec<GrowthSetting>)| {
        let points = settings.into_iter().map(|setting| point(bench, axis, setting));
        Ok(GrowthAxis { axis, points: points.collect::<Result<_, BenchError>>()? })
    };
    axes.into_iter().map(axis).collect()
}

fn point(bench: &mut Bench, axis: &str, setting: GrowthSetting) -> Result<GrowthPoint, BenchError> {
    let GrowthSetting { value, scene, lights, size: [width, height], reference_divisor: smaller } = setting;
    bench.step(format!("{axis} {value}"));
    let posed = scene::pose(scene.clone(), 0.0);
    for side in &mut bench.backends {
        side.renderer.set_scene(&posed)?;
        side.renderer.set_shadow_settings(ShadowSettings::default())?;
    }
    let view = view(width, height);
    let mut frame = FrameRequest { view: view.clone(), lights: LightInstance::numbered(lights.clone())? };
    let mut costs: Vec<Vec<StageCost>> = vec![Vec::new(); bench.backends.len()];
    for k in 0..=bench.options.repeats {
        frame.lights[0] = instance(0, moved(&lights[0], k, RADIUS))?;
        for (side, costs) in bench.backends.iter_mut().zip(&mut costs) {
            let cost = timed(&mut side.renderer, &frame)?.1;
            // The first frame fills the caches and is not timed.
            if k > 0 {
                costs.push(cost);
            }
        }
    }
    frame.lights[0] = instance(0, lights[0].clone())?;
    let mut counted: Vec<WorkCounts> = Vec::new();
    for side in &mut bench.backends {
        counted.push(side.renderer.record_display(&frame.view, &frame.lights)?.1.counters.into());
        side.renderer.drop_view(ViewSlot::default());
    }
    let view = View { width: width / smaller, height: height / smaller, ..view };
    let errors = error::errors_of_backends(&mut bench.backends, &scene, &lights, &view)?;
    let of_side =
        |((costs, counted), error): ((&Vec<StageCost>, _), _)| GrowthCosts { frame: Costs::of(costs), counted, error };
    let mut grown: Vec<GrowthCosts> = costs.iter().zip(counted).zip(errors).map(of_side).collect();
    let by_wgpu = grown.drain(1..).next();
    Ok(GrowthPoint { value, width, height, grown: grown.remove(0), by_wgpu })
}

/// Returns a spotlight above the balls and to one side, aimed at them.
fn spot() -> Light {
    let source = DVec3::new(-1.2, 4.2, 1.8);
    let rotation = DQuat::from_rotation_arc(DVec3::NEG_Z, (-source).normalize());
    Light::spot().with(TRANSLATION, source).with(ROTATION, rotation).with(CONE_ANGLE, CONE).with(INTENSITY, 60.0)
}

/// Returns the distance from the light to the balls.
fn length() -> f64 {
    spot().get(TRANSLATION).length()
}

/// Returns a scene of balls on a floor, with about `inside` triangles in the light and `outside` triangles beside it.
fn balls(inside: u32, outside: u32) -> Scene {
    let half = f64::from(SIDE - 1) / 2.0;
    let square = |triangles: u32, middle: f64| {
        // A ball has 4 `rings`^2 triangles.
        let rings = (f64::from(triangles) / f64::from(4 * SIDE * SIDE)).sqrt().round() as u32;
        let cells = (0..SIDE).flat_map(|row| (0..SIDE).map(move |column| (row, column)));
        let cells = cells.filter(move |_| triangles > 0);
        cells.map(move |(row, column)| {
            let [x, z] = [column, row].map(|index| 0.36 * (f64::from(index) - half));
            PlacedPrimitive(ball(rings.max(3)), place([0.15; 3], 0.0, [middle + x, 0.15, z]))
        })
    };
    grey_scene(std::iter::once(floor()).chain(square(inside, 0.0)).chain(square(outside, OUTSIDE)))
}

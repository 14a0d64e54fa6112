//! `bendylights eval`: evaluates a light at points.

use std::path::PathBuf;

use clap::ValueEnum;
use glam::DVec3;
use light::{CheckedLight, Tube, TubeLocation};
use protocol::point_file::WrittenPoint;
use protocol::{Evaluation, Visibility};
use reference::{LinkedNodes, Reference};
use scene::Scene;

use crate::error::Error;
use crate::render::open_scene;
use crate::usage::print_objects;
use crate::{files, gpu};

#[derive(clap::Args)]
#[command(after_help = "\
Prints a JSON array with one object a point:
  inside     whether the light reaches the point, were nothing in the way
  segment    segment of the curve, from 0
  u, t       place along that segment, 0 to 1, and along the whole light: t = segment + u
  v, w       place across the tube, in radii: v^2 + w^2 <= 1
  radius     radius of the tube there, in world units
  direction  unit vector in the world from the point to where its light comes from
  roots      every t at which the point lies in the tube, ascending
With --scene also:
  visible    whether nothing is in the way
  occluder   name of the first node on the light's way that is, from its source; else null
Outside there are only inside and roots.

A point that was read off a surface and rounded lies a little above or below it. So what is in the way is asked of the
nearest surface within the point's precision, where there is one: how far rounding may have moved a point whose
coordinates were typed with as many decimals ([1.25, 0.5, 2] has two: 0.0087), at most a hundredth of the scene's
size. Type zeros (0.50000) for a point that is finer than it looks; give --precision where decimals do not tell, as
for positions from a depth picture. With --precision 0 each point is taken for exact.

Examples:
  echo '{\"type\": \"bendy\", \"points\": [[0,0,0],[0,0,-1],[1,0,-2]], \"radii\": [0.1,0.4,0.8]}' > light.json
  echo '[[0, 0, -1], [5, 0, 0]]' | bendylights eval light.json
  bendylights eval light.json points.json --scene room.glb")]
pub struct Args {
    /// Light file with one BendyLight
    #[arg(value_name = "LIGHT.json")]
    light: PathBuf,
    /// World positions, a JSON array of [x, y, z]; `-` reads standard input
    #[arg(value_name = "POINTS.json", default_value = "-")]
    points: PathBuf,
    /// Scene whose objects may be in the way: a glTF file, or `demo:NAME`. Light is followed along its curve
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    /// Distance that points may lie from the surface they were read from, world units [default: by their
    /// decimals]
    #[arg(long, value_name = "LENGTH", requires = "scene", value_parser = length)]
    precision: Option<f64>,
    /// Device and precision of the answer; shadows are always found in double precision
    #[arg(long, value_enum, default_value = "f64")]
    on: EvalDevice,
}

#[derive(Clone, Copy, ValueEnum)]
enum EvalDevice {
    /// The CPU in double precision
    F64,
    /// The CPU in single precision
    F32,
    /// The GPU in single precision, by the renderer's own shader code
    Gpu,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if matches!(args.on, EvalDevice::Gpu) {
        cli::restart_without_window_system();
    }
    let file = args.light.display().to_string();
    let light = files::read_one_light(&args.light)?;
    let Some(tube) = light.tube() else { return Err(Error::EvalWithoutTube { file }) };
    let written = files::read_points(&args.points)?;
    let points: Vec<DVec3> = written.iter().map(|point| point.position).collect();
    let locations: Vec<TubeLocation> = match args.on {
        EvalDevice::F64 => points.iter().map(|&point| tube.locate(point)).collect(),
        EvalDevice::F32 => {
            // Like the renderer, single precision uses only the part of the light in which the points lie.
            let part = tube.part_near_points(&points);
            let tube = Tube::<f32>::from(&part.tube);
            points.iter().map(|&point| part.to_whole_light(&tube.locate(point))).collect()
        }
        EvalDevice::Gpu => render::locate(&*gpu::open_gpu()?, tube, &points)?,
    };
    let scene = args.scene.as_deref().map(open_scene).transpose()?.map(|loaded| loaded.scene);
    let shadows = scene.map(|scene| Shadows::new(scene, &light, args.precision));
    let objects: Vec<String> = locations
        .iter()
        .zip(&written)
        .map(|(location, point)| {
            let visibility = shadows.as_ref().and_then(|shadows| shadows.visibility(tube, location, point));
            let evaluation = Evaluation::new(location, visibility);
            serde_json::to_string(&evaluation).expect("finite numbers and string keys")
        })
        .collect();
    Ok(print_objects(&objects)?)
}

/// Parses a length.
fn length(text: &str) -> Result<f64, String> {
    let length = text.parse().ok().filter(|length| (0.0..f64::INFINITY).contains(length));
    length.ok_or("write it as a number of world units, 0 or more".into())
}

/// Shadows in a scene, for points of limited precision.
struct Shadows {
    reference: Reference,
    /// Nodes of the scene that cast shadows.
    linked: LinkedNodes,
    /// Precision that the command line gives for all points.
    precision: Option<f64>,
    /// Largest precision that is taken from the decimals of a point. A point with fewer decimals was typed by hand and
    /// not read from a surface.
    max_precision: f64,
}

/// Largest precision that is taken from the decimals of a point, as a share of the scene's size.
const MAX_PRECISION_SHARE: f64 = 0.01;

impl Shadows {
    fn new(scene: Scene, light: &CheckedLight, precision: Option<f64>) -> Self {
        let posed = scene::pose(scene, 0.0);
        let max_precision = MAX_PRECISION_SHARE * 2.0 * posed.half_extent.length();
        Self { linked: LinkedNodes::new(&posed, light), reference: Reference::new(posed), precision, max_precision }
    }

    /// Returns the distance that `point` may lie from the surface it was read from: half a unit of the last
    /// digit along each axis.
    fn precision(&self, point: &WrittenPoint) -> f64 {
        let rounding = 3.0_f64.sqrt() * point.last_digit / 2.0;
        self.precision.unwrap_or(rounding.min(self.max_precision))
    }

    /// Computes the visibility of the light from a point through the scene; `None` outside the light.
    fn visibility(&self, tube: &Tube<f64>, location: &TubeLocation, written: &WrittenPoint) -> Option<Visibility> {
        let inside = location.point.as_ref()?;
        let surface = self.reference.surface_near(written.position, self.precision(written));
        let point = surface.unwrap_or(written.position);
        // Always in double precision. At the light's rim the surface may lie just outside the light.
        let coords = tube.locate(point).point;
        let node = self.reference.occluding_node(tube, &self.linked, coords.as_ref().unwrap_or(inside), point);
        let occluder = node.map(|node| self.reference.bvh.posed.scene.nodes[node].name.clone());
        Some(Visibility { visible: occluder.is_none(), occluder })
    }
}

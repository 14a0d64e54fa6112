//! `bendylights eval`: where points lie in a light.

use std::path::PathBuf;

use bendy::{Location, Tube};
use clap::ValueEnum;
use glam::DVec3;
use protocol::{Evaluation, Visibility};
use reference::Reference;
use render::Gpu;
use scene::LightKind;

use crate::error::Error;
use crate::render::open_scene;
use crate::{answer, files, headless};

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
    /// What computes the answer; shadows are always found in double precision
    #[arg(long, value_enum, default_value = "f64")]
    on: On,
}

#[derive(Clone, Copy, ValueEnum)]
enum On {
    /// The CPU in double precision
    F64,
    /// The CPU in single precision
    F32,
    /// The GPU in single precision, by the renderer's own shader code
    Gpu,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if matches!(args.on, On::Gpu) {
        headless::prepare();
    }
    let file = args.light.display().to_string();
    let LightKind::Bendy(light) = files::read_one_light(&args.light)?.kind else {
        return Err(Error::EvalOfSpot { file });
    };
    let points = files::read_points(&args.points)?;
    let tube = Tube::<f64>::new(&light).map_err(|reason| Error::BadLight { file, reason })?;
    let locations: Vec<Location> = match args.on {
        On::F64 => points.iter().map(|&point| tube.locate(point)).collect(),
        On::F32 => {
            let tube = Tube::<f32>::from(&tube);
            points.iter().map(|&point| tube.locate(point)).collect()
        }
        On::Gpu => render::locate(&Gpu::new()?, &light, &points)?,
    };
    let scene = args.scene.as_deref().map(open_scene).transpose()?.map(|loaded| loaded.scene);
    let reference = scene.as_ref().map(Reference::new);
    let objects: Vec<String> = locations
        .iter()
        .zip(&points)
        .map(|(location, &point)| {
            let visibility = reference.as_ref().and_then(|scene| visibility(scene, &tube, location, point));
            let evaluation = Evaluation::new(location, visibility);
            serde_json::to_string(&evaluation).expect("finite numbers and string keys")
        })
        .collect();
    answer(&format!("[{}]", objects.join(",\n ")))
}

/// Whether light gets to a point through the scene; `None` outside the light.
fn visibility(
    reference: &Reference,
    tube: &Tube<f64>,
    location: &Location,
    point_in_world: DVec3,
) -> Option<Visibility> {
    let node = reference.occluder(tube, location.point.as_ref()?, point_in_world);
    let occluder = node.map(|node| reference.scene.nodes[node].name.clone());
    Some(Visibility { visible: occluder.is_none(), occluder })
}

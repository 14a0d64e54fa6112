//! `bendylights bench sweep`: checks pictures of random lights against the reference.

use std::path::PathBuf;

use ::bench::sweep;
use cli::Size;

use super::{measure, name_of};
use crate::error::Error;
use crate::render::open_scene;
use crate::usage::whole_number_parser;

#[derive(clap::Args)]
#[command(after_help = "\
Puts random lights of each shape, turned about themselves, over things on floors that are smaller than they, as large and
wider, between walls, in rooms and under roofs. Half of the poses are looked at from close by, where surfaces meet at a
shadow and pixels are as wide as the texels of its map. Draws each pose by wgpu and by the processor and holds both to the
reference. A pixel is judged where the reference says the same of all within 1.5 texels of a shadow map. Prints JSON, for
each shape and backend:
  poses, failed        how many; in those that failed less than half of what is seen is stable enough to be judged
  stable, wrong        pixels judged, and those whose shadow is another
  posesWrong, worst    poses with a wrong pixel, and the most in one
  radianceRmseP50      relative error of radiance over the other pixels, half of poses; radianceRmseMax the worst
  frameMsP50           milliseconds of a picture whose light is new, half of poses
and each pose that is not right.

Examples:
  bendylights bench sweep -o sweep.svg
  bendylights bench sweep --shape omni --pose 17 --pictures wrong
  bendylights bench sweep --scene room.glb --scene street.glb")]
pub struct Args {
    /// Poses of each shape
    #[arg(long, default_value_t = 200, value_name = "COUNT", value_parser = whole_number_parser(1..=1_000_000_u32))]
    poses: u32,
    /// The same seed makes the same poses
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole_number_parser(0..=u64::MAX))]
    seed: u64,
    /// Width and height of the pictures in pixels
    #[arg(long, default_value = "96x64", value_name = "WxH")]
    size: Size,
    /// Texels along each side of shadow maps
    #[arg(long, default_value_t = 2048, value_name = "TEXELS", value_parser = whole_number_parser(16..=8192_u32))]
    shadow_resolution: u32,
    /// Only lights of this shape; may be given more than once
    #[arg(long, value_name = "SHAPE", value_parser = sweep::SHAPES.map(|(name, _)| name))]
    shape: Vec<String>,
    /// Only the pose of this number
    #[arg(long, value_name = "NUMBER")]
    pose: Option<usize>,
    /// A scene to sweep over besides the random ones; may be given more than once
    #[arg(long, value_name = "SCENE")]
    scene: Vec<String>,
    /// Chart to write: run time against error, pose by pose
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
    /// Folder for a picture of each pose that is not right
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    cli::restart_without_window_system();
    cli::make_folder(args.pictures.as_deref())?;
    let file = |scene: &String| {
        let loaded = open_scene(scene)?;
        Ok(sweep::SceneFile { name: name_of(scene), scene: loaded.scene, cameras: loaded.contents.cameras })
    };
    let options = sweep::SweepOptions {
        poses: args.pose.map_or_else(|| (0..args.poses as usize).collect(), |pose| vec![pose]),
        seed: args.seed,
        resolution: args.shadow_resolution,
        size: [args.size.width, args.size.height],
        shapes: (sweep::SHAPES.into_iter().map(|(name, _)| name))
            .filter(|name| args.shape.is_empty() || args.shape.iter().any(|shape| shape == name))
            .collect(),
        scenes: args.scene.iter().map(file).collect::<Result<_, Error>>()?,
        pictures: args.pictures.clone(),
    };
    measure(args.output.as_deref(), |progress| sweep::run(&options, progress)).map(drop)
}

//! `bendylights bench shadow`: measures the cost and the error of bent shadows.

use std::path::PathBuf;

use ::bench::shadow;
use cli::Size;

use super::measure;
use crate::error::Error;
use crate::gpu;

#[derive(clap::Args)]
#[command(after_help = "\
Renders five scenes by the reference, and by the GPU with the shadow map's resolution, splitting, filter and mesh error
turned one at a time. Prints JSON, for each scene and setting:
  stages               milliseconds for G-buffer, shadow map and lighting, nothing kept from a picture before
  radianceRmse         relative error of radiance where no shadow's edge is near
  displacementPixels   how far shadows' edges are from where they should be, square to them
  displacementTexels   of pixels on the wrong side of an edge, how many texels of the map they are from it
  missed, false        pixels lit or shadowed wrongly more than 1.5 texels from an edge
  offEdge              pixels off by more than a tenth of the light with no edge within two pixels

Example:
  bendylights bench shadow -o shadow.svg --pictures differences")]
pub struct Args {
    /// Width and height of the pictures in pixels
    #[arg(long, default_value = "343x191", value_name = "WxH")]
    size: Size,
    /// Chart to write: run time against error
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
    /// Folder for pictures of the differences, one a scene and setting
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    cli::restart_without_window_system();
    cli::make_folder(args.pictures.as_deref())?;
    let (size, pictures) = ([args.size.width, args.size.height], args.pictures.as_deref());
    let gpu = gpu::open_gpu()?;
    measure(args.output.as_deref(), |progress| shadow::run(&gpu, size, pictures, progress)).map(drop)
}

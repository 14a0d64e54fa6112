//! `bendylights-studies direction`: from where light should be said to arrive.

use std::path::{Path, PathBuf};

use cli::{Output, Size, answer, progress};
use studies::StudyError;
use studies::direction;

#[derive(clap::Args)]
#[command(after_help = "\
A BendyLight's `direction` says from where its light arrives at a surface: along the tube (the default) or along the
path that it took. This compares both with the paper's eq. 9 as printed and with a path that is smooth at joints, over a
grid of bends and tapers and on demo:vases. Prints JSON:
  nanoseconds  what each costs
  grid         for each R kappa (the tube's radius times the curve's bend; 1 folds) and taper (how fast the radius
               changes along the curve): degrees off the path, the jump at a joint, and the step in the shading that it makes
  picture      how many pixels are shaded as facing the light while it arrives from behind, or the other way round

Example:
  bendylights-studies direction -o direction.svg --pictures .")]
pub struct Args {
    /// Width and height of the pictures in pixels
    #[arg(long, default_value = "686x382", value_name = "WxH")]
    size: Size,
    /// Chart to write: degrees over bend, a curve a taper
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
    /// Folder for pictures: one a direction, and panels.png with all four
    #[arg(long, value_name = "DIR")]
    pictures: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), StudyError> {
    let output = args.output.as_deref().map(Output::create_chart).transpose()?;
    cli::make_folder(args.pictures.as_deref())?;
    let demo = assets::demo("vases").expect("a demo of that name");
    let subject = (&demo.scene, &demo.contents.lights[..], demo.contents.cameras.first());
    let Size { width, height } = args.size;
    let bar = progress(u64::from(height));
    let (report, pictures) = direction::run(subject, [width, height], || bar.inc(1))?;
    bar.finish_and_clear();
    if let Some(output) = output {
        output.write(direction::chart(&report)?.as_bytes())?;
    }
    if let Some(folder) = &args.pictures {
        pictures.iter().try_for_each(|picture| write(folder, picture))?;
    }
    Ok(answer(&serde_json::to_string_pretty(&report).expect("plain data with string keys"))?)
}

fn write(folder: &Path, picture: &direction::Picture) -> Result<(), StudyError> {
    Ok(Output::create(&folder.join(&picture.file_name))?.write(&picture.png)?)
}

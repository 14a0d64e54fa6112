//! `bendylights bench frame`: measures the stages of a frame.

use std::path::PathBuf;

use ::bench::frame::{self, FrameSubject, GrowthPlan};
use cli::{Size, print_note};

use super::{PeerArgs, measure, name_of};
use crate::error::Error;
use crate::gpu::BackendArgs;
use crate::picture::choose_camera;
use crate::render::open_scene_with_lights;
use crate::usage::whole_number_parser;

/// Number of bent lights, of which one moves, in the comparison with a single light.
const CROWD: usize = 64;

#[derive(clap::Args)]
#[command(after_help = "\
Draws a scene under one bent light, its first light; a straight one is bent for that. Where the processor lights
pictures (--backend) wgpu is measured in the same run, in turns with it. Tables go to standard error, JSON to standard
output:
  edits       a row an edit and backend: first frame, camera, light move, control point, radius, color, intensity, mute,
              idle (the same picture asked for again); wall and CPU milliseconds of the whole frame with its read-back,
              and of each stage drawn by itself; triangles, texels, pixels and bytes that it worked on
  errors      how far each backend's picture is from the reference, where no shadow's edge is near, in a picture a
              fourth as wide and high
  sideBySide  some frames in a row of each, in turns: the bent light, with half its map too, a spotlight, the spotlight as
              a BendyLight, the bent light with all drawn that is left out else, an intensity edit, 64 bent lights of
              which one moves; where the processor is measured, most of them by wgpu too (bentByWgpu ..); other renderers
              with --peers
  growth      with --growth, in scenes of its own: triangles in the tube and outside of it, 10 thousand to a million;
              lights, 1 to 64, one moved; segments, 1 to 16; pixels, 360p to 4K; each with its error against the
              reference, in a picture a fourth as wide and high, an eighth along pixels; by wgpu too (byWgpu) where the
              processor is measured

Other renderers are scripts: each folder in DIR with a bench.py is one. It is run as `python bench.py FRAMES` and
prints, a line of JSON each, {\"name\": .., \"version\": .., \"ms_median\": ..}; their minimum is the least of three
such medians. What they draw is theirs to say: name the same scene. A setup.sh in DIR, where it has one, makes the
virtual environment DIR/.venv that their Python is looked for in.

Examples:
  bendylights bench frame -o frame.svg
  bendylights bench frame --backend native --scene demo:arbor -o frame.svg
  bendylights bench frame --scene bench.glb --growth --peers peers --python venv/bin/python -o frame.svg > frame.json")]
pub struct Args {
    /// Scene: a glTF file, or `demo:NAME`
    #[arg(long, value_name = "SCENE", default_value = "demo:vases")]
    scene: String,
    /// Width and height of the view in pixels
    #[arg(long, default_value = "686x382", value_name = "WxH")]
    size: Size,
    /// Frames of each kind
    #[arg(long, default_value_t = 21, value_name = "N", value_parser = whole_number_parser(1..=10_000_u32))]
    repeats: u32,
    /// Measure how frames grow, too: some minutes
    #[arg(long)]
    growth: bool,
    #[command(flatten)]
    peers: PeerArgs,
    #[command(flatten)]
    backend: BackendArgs,
    /// Chart to write
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    cli::restart_without_window_system();
    let peers = args.peers.find_peers()?;
    let subject = subject(args)?;
    let growth = args.growth.then(GrowthPlan::full);
    let repeats = args.repeats as usize;
    let (peers, growth) = (peers.as_ref(), growth.as_ref());
    let options = frame::FrameBenchOptions { repeats, crowd: CROWD, backend: args.backend.wanted(), peers, growth };
    let report = measure(args.output.as_deref(), |progress| frame::run(&subject, options, progress))?;
    report.table().lines().for_each(print_note);
    Ok(())
}

/// Returns the scene under its first light, from its first camera.
fn subject(args: &Args) -> Result<FrameSubject, Error> {
    let loaded = open_scene_with_lights(&args.scene, None)?;
    let Size { width, height } = args.size;
    let contents = &loaded.contents;
    let reach = light::SceneBounds::from(&loaded.scene);
    let camera = choose_camera(&args.scene, None, f64::from(width) / f64::from(height), &reach, &contents.cameras)?;
    let Some(light) = contents.lights.first() else { return Err(Error::NothingLit(args.scene.clone())) };
    let subject = FrameSubject::new(&name_of(&args.scene), loaded.scene, camera, light.light(), [width, height]);
    subject.map_err(|reason| Error::BadLight { file: args.scene.clone(), reason })
}

//! `bendylights bench drag`: measures if drags land, and how long they take.

use std::path::PathBuf;

use ::bench::drag::{self, TrialScene};
use assets::LoadedScene;
use cli::Size;

use super::measure;
use crate::error::Error;
use crate::render::open_scene;
use crate::usage::whole_number_parser;

#[derive(clap::Args)]
#[command(after_help = "\
Makes random drags in random lights over each scene, of shadows, hotspots, highlights and the sides of surfaces that are turned
most to the light, as `bendylights drag` does, and beside them by the formulas of the BendyLights paper, which move a light
once and do not look where its feature ends, by a solver that changes the light, not the picture, as little as it can, and
with the defaults of the page: the best of the alternatives.
Prints JSON; for each kind (feature, whole lights or control points, less or more than a tenth of the picture's width):
  iterations  steps of the solver
  jumps, jumpsOfLeastChange  between cursors a pixel apart: steps, jumps (a control point moves by more than a twentieth of
            the light's length), and the longest step
  ours, best, leastChange, paper
    landed    features that end within half a pixel of the cursor
    folded    lights that fold and cannot be drawn
    lost      features that are not in the picture afterwards
    px        from the cursor to the feature, in pixels
    residual  how far the equations are from holding at the cursor: radii of shadow and hotspot, else radians
    visible, seen  landed features that could be seen where they were taken, and those of them seen at the cursor
    kept      share of the lit picture that keeps half of its brightness after a landed drag: median and worst tenth
    changed   share of the picture that changes visibly by a landed drag
    ms        a drag's time, with its picks

Examples:
  bendylights bench drag -o drag.svg
  bendylights bench drag demo:vases room.glb --drags 100")]
pub struct Args {
    /// glTF files (.gltf or .glb), or `demo:NAME`
    #[arg(default_value = "demo:vases", value_name = "SCENE")]
    scenes: Vec<String>,
    /// Drags of each of the sixteen kinds in each scene
    #[arg(long, default_value_t = 25, value_name = "N", value_parser = whole_number_parser(1..=100_000_u32))]
    drags: u32,
    /// Another number, other drags
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = whole_number_parser(0..=u64::MAX))]
    seed: u64,
    /// Width and height of the picture in pixels
    #[arg(long, default_value = "686x382", value_name = "WxH")]
    size: Size,
    /// Chart to write: shares of drags over distance, loss and time
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let Size { width, height } = args.size;
    let stages = args.scenes.iter().map(|name| {
        let LoadedScene { scene, contents, .. } = open_scene(name)?;
        Ok(TrialScene::new(name, scene, &contents.cameras, [width, height]))
    });
    let stages = stages.collect::<Result<Vec<_>, Error>>()?;
    measure(args.output.as_deref(), |progress| drag::run(&stages, args.drags as usize, args.seed, progress)).map(drop)
}

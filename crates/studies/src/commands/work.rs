//! `bendylights-studies work`: the cost of drags.

use cli::progress;
use drag::MAX_DRAG_STEPS;
use serde_json::json;
use studies::StudyError;
use studies::work::{random, search, stages};

use super::print_json;

/// Size in pixels of the picture in which features are dragged.
const SIZE: [u32; 2] = [640, 360];

#[derive(clap::Args)]
#[command(after_help = "\
Makes random drags of lights of 2 to 258 control points, of which any number is chosen, with up to 256 pins, in the demo and
among many triangles in one place; then searches for the most expensive one, at random and by changing one number of the most
expensive one until then. Steps are counted, the same on every machine; seconds are this machine's.

Prints JSON: `drags`, each with its size, `steps`, `seconds` and how it ended, and `mostExpensive`, as the search found them.

Examples:
  bendylights-studies work --drags 1000 --tries 0
  bendylights-studies work --drags 0 --tries 1000")]
pub struct Args {
    /// Random drags
    #[arg(long, default_value_t = 200, value_name = "N")]
    drags: usize,
    /// Tries of the search
    #[arg(long, default_value_t = 200, value_name = "N")]
    tries: usize,
    /// Another number, other drags
    #[arg(long, default_value_t = 1, value_name = "S")]
    seed: u64,
    /// Triangles in one place
    #[arg(long, default_value_t = 64_000, value_name = "N")]
    triangles: usize,
}

pub fn run(args: &Args) -> Result<(), StudyError> {
    let stages = stages(args.triangles, SIZE);
    let bar = progress((args.drags + args.tries) as u64);
    let drags = random(&stages, args.drags, args.seed, MAX_DRAG_STEPS, || bar.inc(1));
    let most_expensive = search(&stages, args.tries, args.seed, MAX_DRAG_STEPS, || bar.inc(1));
    bar.finish_and_clear();
    let report = json!({ "mostSteps": MAX_DRAG_STEPS, "drags": drags, "mostExpensive": most_expensive });
    Ok(print_json(&report)?)
}

//! `bendylights bench solver`: compares solvers by speed, accuracy and failures.

use std::path::PathBuf;

use ::bench::solver::{self, METHODS, Method};
use render::{Gpu, Host};

use super::measure;
use crate::error::Error;

#[derive(clap::Args)]
#[command(after_help = "\
Each pixel asks each segment of a light: where is your curve square to me? This puts the question to the product's solver
and to eight others, in f32 and f64, for 15 families of segments and points (nearly straight, hairpins, cusps, far away,
near the evolute, ...), and compares the answers with roots known to thirty digits. Prints JSON:
  ours       solves, wrong roots and NaN of the product's solver; with either, the exit code is not 0
  methods    run time on one core, error (p50, p99.9, max), roots missed, made up (spurious) or over the bars
             (inaccurate), NaN. errorU is in the curve's own parameter, and large where the question itself is
             ill-conditioned; errorEpsCond divides by that condition and the width's epsilon: about 1 is as good as
             the width can, and the bars are stated in it
  sixteenWide, adapter
             the product's solver sixteen at once on one core, and on the adapter: solves a second

Examples:
  bendylights bench solver -o solver.svg
  bendylights bench solver --only ours --inputs 6700000     1e8 inputs, each in f32 and f64; some minutes")]
pub struct Args {
    /// Points of each of the 15 families
    #[arg(long, default_value_t = 60_000, value_name = "N", value_parser = clap::value_parser!(u64).range(100..=1_000_000_000))]
    inputs: u64,
    /// Method to measure beside the product's own, by its name in the answer; all if left out. May be
    /// given several times
    #[arg(long, value_name = "METHOD", value_parser = method)]
    only: Vec<Method>,
    /// Chart to write: run time against error
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

/// Parses the name of a method, as in the answer.
fn method(name: &str) -> Result<Method, serde_json::Error> {
    serde_json::from_value(name.into())
}

pub fn run(args: &Args) -> Result<(), Error> {
    cli::restart_without_window_system();
    let methods = if args.only.is_empty() { &METHODS[..] } else { &args.only };
    // The CPU's figures are useful even without an adapter.
    let gpu = Gpu::open(Host::default()).ok();
    let report = measure(args.output.as_deref(), |progress| solver::run(args.inputs, methods, gpu.as_ref(), progress))?;
    let (wrong, nan) = (report.ours.wrong, report.ours.nan);
    if wrong + nan > 0 { Err(Error::SolverWrong { wrong, nan }) } else { Ok(()) }
}

//! `bendylights-studies stress`: properties that must hold for all lights and scenes.

use std::time::Duration;

use cli::progress;
use studies::StudyError;
use studies::stress::{self, Length, Property, StressOptions};

use super::print_json;

#[derive(clap::Args)]
#[command(after_help = "\
Makes random and unkind lights, points, scenes and cameras (hairpins, near folds, coincident points, radii of zero, slivers,
huge triangles, singular transforms, a million units from the origin, ...) and holds every part of the product to bounds that
follow from the conditioning of each case:
  solver, frame, round-trip, joints, world      the model, in f64 and f32
  locate, map                                   the adapter's shaders against the model
  lone-plane, wall, shadow                      shadows against a walk along the light's paths in f64
  finite                                        every AOV of every picture, and what a screen shows
The pictures of the last four are lit by the adapter and by the processor.
Prints JSON: for each, cases, comparisons and `worstShare`, the largest error as a share of its bound: 0 where things are
right or wrong without a size, as lit or in shadow; `failure` is null where all held. A case that fails is made as simple as
it can be and printed with its seed, and the exit code is not 0.

Examples:
  bendylights-studies stress --minutes 10
  bendylights-studies stress --only wall --seed 1234 --cases 1    the case that a run printed")]
pub struct Args {
    /// Minutes to look, in all
    #[arg(long, default_value_t = 1.0, value_name = "N", value_parser = minutes)]
    minutes: f64,
    /// Look at so many cases of each property instead
    #[arg(long, value_name = "N", conflicts_with = "minutes", value_parser = clap::value_parser!(u64).range(1..))]
    cases: Option<u64>,
    /// Seed to begin with; another number, other cases
    #[arg(long, default_value_t = 1, value_name = "S")]
    seed: u64,
    /// Property to look at; all if left out. May be given several times
    #[arg(long, value_name = "PROPERTY")]
    only: Vec<Property>,
    /// Spoil what is looked at: each property must then fail, which shows that it would
    #[arg(long)]
    planted: bool,
}

fn minutes(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(minutes) if 0.0 < minutes && minutes <= 100_000.0 => Ok(minutes),
        _ => Err("a number of minutes, such as 0.5 or 10".into()),
    }
}

pub fn run(args: &Args) -> Result<(), StudyError> {
    cli::restart_without_window_system();
    let properties = if args.only.is_empty() { Property::ALL.to_vec() } else { args.only.clone() };
    let length = match args.cases {
        Some(cases) => Length::Cases(cases),
        None => Length::Time(Duration::from_secs_f64(60.0 * args.minutes)),
    };
    let options = StressOptions { properties, seed: args.seed, length, planted: args.planted };
    let bar = progress(1_000);
    let result = stress::run(&options, |share| bar.set_position((1_000.0 * share) as u64));
    bar.finish_and_clear();
    let report = result?;
    print_json(&report)?;
    match report.failed().next() {
        None => Ok(()),
        Some((property, failure)) => {
            let (count, property, seed) = (report.failed().count(), property.name(), failure.seed);
            Err(StudyError::Broken { count, property, seed })
        }
    }
}

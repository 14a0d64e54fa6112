//! `bendylights-studies`, with a command for each study. Exit codes are those of `bendylights`: 0 if done; 2 if the
//! input is wrong, with a sentence on standard error that says how to correct it; 1 if this machine cannot do it or the
//! product is wrong.

mod commands;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use commands::{stress, work};

/// Studies of the light model: what its decisions rest on, measured again, and what breaks it.
#[derive(Parser)]
#[command(version, after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    study: Study,
}

#[derive(Subcommand)]
enum Study {
    /// Does anything break, for any light and scene? Random and unkind cases against bounds, for as long as you like
    Stress(stress::Args),
    /// Cost of drags: counted steps and seconds, and a search for the most expensive one
    Work(work::Args),
}

const EXAMPLES: &str = "\
Examples:
  bendylights-studies stress --minutes 10
  bendylights-studies work

'bendylights-studies help STUDY' says more about each. What users ask, `bendylights bench` answers.";

fn main() -> ExitCode {
    let done = match Cli::parse().study {
        Study::Stress(args) => stress::run(&args),
        Study::Work(args) => work::run(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            cli::print_note(&format!("error: {error}"));
            ExitCode::from(error.exit_code())
        }
    }
}

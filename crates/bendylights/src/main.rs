//! `bendylights`, the program that users install: a headless render server and a command line.
//!
//! Each command has its module. The arguments, files and JSON of commands are a contract with users.
//!
//! The program only connects the other crates: it reads arguments and files, calls the crates and prints
//! answers. It has no light model, renderer, server or JSON format of its own.
//!
//! Exit codes: 0 for success; 2 if the input is wrong, and one sentence on standard error names the correction;
//! 1 if this machine fails (no GPU driver, disk full).
//!
//! Begin with `Command` below, then `render.rs` for a picture, `serve.rs` for the server and `error.rs` for all
//! errors.

mod backup;
mod bench;
mod bend;
mod bundle;
mod drag;
mod error;
mod eval;
mod example;
mod export;
mod files;
mod gpu;
mod import;
mod known_scenes;
mod parameters;
mod picture;
mod picture_files;
mod probe;
mod render;
mod replay;
mod resolve;
mod scenes;
mod serve;
mod sessions;
mod usage;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tikv_jemallocator::Jemalloc;

/// Allocator that returns unused memory to the system within seconds, from a background thread.
#[global_allocator]
static ALLOCATOR: Jemalloc = Jemalloc;

/// Renders scenes lit by BendyLights: spotlights whose light travels along a curve.
#[derive(Parser)]
#[command(version = env!("BENDYLIGHTS_VERSION"), after_help = EXAMPLES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Say nothing on standard error but why it fails: no notes, no progress
    #[arg(long, short, global = true)]
    quiet: bool,
    /// Print JSON: what `sessions` and `parameters` list, and why a command fails, on standard error
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Render a scene to a PNG or EXR picture
    Render(render::Args),
    /// Say where points lie in a light
    Eval(eval::Args),
    /// Turn a straight light into a BendyLight, ready to be bent
    Bend(bend::Args),
    /// Drag shadows, hotspots and highlights of lights to where they should be
    Drag(drag::Args),
    /// Say why a pixel is lit or not, light by light
    Probe(probe::Args),
    /// List what can be set on lights, control points and cameras
    Parameters(parameters::Args),
    /// List the demo scenes
    Scenes,
    /// Write a scene and a light file to begin with
    Example(example::Args),
    /// Serve sessions to browsers and programs
    Serve(serve::Args),
    /// List the sessions of a data folder
    Sessions(sessions::Args),
    /// Copy a data folder while a server uses it
    Backup(backup::Args),
    /// Write a session's edit log to a file
    Export(export::Args),
    /// Make a session of a log file
    Import(import::Args),
    /// Make a log's edits again, and prove that they give the same document
    Replay(replay::Args),
    /// Measure how fast it is here, and how accurate its shadows are
    Bench(bench::Args),
}

const EXAMPLES: &str = "\
Examples:
  bendylights scenes
  bendylights serve
  bendylights render demo:vases --samples 16 -o vases.png
  bendylights bend spot.json --segments 3 > bent.json
  echo '[[0, 1, 0], [0, 2, 1]]' | bendylights eval bent.json

'bendylights help COMMAND' says more about each command.";

fn main() -> ExitCode {
    let Cli { command, quiet, json } = usage::parse();
    if quiet {
        cli::set_quiet();
    }
    let done = match command {
        Command::Render(args) => render::run(&args),
        Command::Eval(args) => eval::run(&args),
        Command::Bend(args) => bend::run(&args),
        Command::Drag(args) => drag::run(&args),
        Command::Probe(args) => probe::run(&args),
        Command::Parameters(args) => parameters::run(&args, json),
        Command::Scenes => scenes::run(),
        Command::Example(args) => example::run(&args),
        Command::Serve(args) => serve::run(&args),
        Command::Sessions(args) => sessions::run(&args, json),
        Command::Backup(args) => backup::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Import(args) => import::run(&args),
        Command::Replay(args) => replay::run(&args),
        Command::Bench(args) => bench::run(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            usage::print_failure(&error.to_string(), error.exit_code(), json);
            ExitCode::from(error.exit_code())
        }
    }
}

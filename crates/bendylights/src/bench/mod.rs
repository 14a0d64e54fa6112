//! `bendylights bench`: measurements that answer users' questions.

mod drag;
mod frame;
mod isolation;
mod log;
mod session;
mod shadow;
mod solver;
mod sweep;

use std::path::{Path, PathBuf};

use ::bench::{BenchError, Peers, Progress};
use cli::{OutputFile, progress};
use serde::Serialize;

use crate::error::Error;
use crate::usage::print_json;

#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    /// Do drags land, and how long do they take? Random ones, beside the formulas of the BendyLights paper
    Drag(drag::Args),
    /// Time of a frame: each kind of edit stage by stage, beside other lights and renderers, and how frames
    /// grow
    Frame(frame::Args),
    /// Speed of the edit log: edits acknowledged, undone and replayed a second, and opening time over its
    /// length
    Log(log::Args),
    /// Loss of one client to another that does all it can: frames, answers and memory beside each kind of
    /// neighbour
    #[command(name = "neighbours")]
    Isolation(isolation::Args),
    /// Time until an edit is on the screen: drags a control point over a server of its own, on loopback
    Session(session::Args),
    /// Cost and error of bent shadows: run time against error of resolution, splitting and filter
    Shadow(shadow::Args),
    /// Solvers that find a point's place in a light: how fast, how accurate, and whether they ever fail
    Solver(solver::Args),
    /// Are pictures right at first sight? Random lights of each shape over scenes on floors, in rooms and under roofs,
    /// both backends held to the reference
    Sweep(sweep::Args),
}

pub fn run(args: &Args) -> Result<(), Error> {
    match &args.question {
        Question::Drag(args) => drag::run(args),
        Question::Frame(args) => frame::run(args),
        Question::Log(args) => log::run(args),
        Question::Isolation(args) => isolation::run(args),
        Question::Session(args) => session::run(args),
        Question::Shadow(args) => shadow::run(args),
        Question::Solver(args) => solver::run(args),
        Question::Sweep(args) => sweep::run(args),
    }
}

/// Runs a measurement with a progress bar, writes its chart to `output`, and prints its report as JSON. Returns
/// the report.
fn measure<R: Serialize>(
    output: Option<&Path>,
    run: impl FnOnce(&(dyn Fn(Progress) + Sync)) -> Result<(R, String), BenchError>,
) -> Result<R, Error> {
    // The check of the chart's path precedes the measurement, which may take long.
    let output = output.map(OutputFile::create_chart).transpose()?;
    let bar = progress(0);
    let result = run(&|Progress { done, of, what }| {
        bar.set_length(of as u64);
        bar.set_position(done as u64);
        bar.set_message(what);
    });
    bar.finish_and_clear();
    let (report, chart) = result?;
    if let Some(output) = output {
        output.write(chart.as_bytes())?;
    }
    print_json(&report)?;
    Ok(report)
}

/// Returns the path of this program, whose `serve` is measured.
fn this_program() -> Result<PathBuf, Error> {
    std::env::current_exe().map_err(|error| Error::Bench(error.into()))
}

/// Options for other renderers to measure beside.
#[derive(clap::Args)]
struct PeerArgs {
    /// Folder of other renderers to measure in the same run
    #[arg(long, value_name = "DIR")]
    peers: Option<PathBuf>,
    /// Python that has them [default: that of DIR/.venv or DIR/venv]
    #[arg(long, value_name = "PATH", requires = "peers")]
    python: Option<PathBuf>,
}

impl PeerArgs {
    fn find_peers(&self) -> Result<Option<Peers>, BenchError> {
        self.peers.as_deref().map(|folder| Peers::find(folder, self.python.as_deref())).transpose()
    }
}

/// Returns the name of a scene in reports: the file name without its folder.
fn name_of(scene: &str) -> String {
    Path::new(scene).file_name().map_or(scene.into(), |name| name.to_string_lossy().into())
}

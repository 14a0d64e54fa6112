//! `bendylights bench`: answers to questions that people who run it have, measured.

mod direction;
mod session;
mod shadow;
mod solver;
mod stress;

use std::path::Path;

use crate::error::Error;

#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    /// From where should light be said to arrive? Along the tube, along its path, or in between, at bends and joints
    Direction(direction::Args),
    /// How long until an edit is on the screen? Drags a control point over a server of its own, on loopback
    Session(session::Args),
    /// What do bent shadows cost, and how wrong are they? Run time against error of resolution, splitting and filter
    Shadow(shadow::Args),
    /// Which solver finds a point's place in a light, how fast, how accurately, and does it ever fail?
    Solver(solver::Args),
    /// Does anything break, for any light and scene? Random and unkind cases against bounds, for as long as you like
    Stress(stress::Args),
}

pub fn run(args: &Args) -> Result<(), Error> {
    match &args.question {
        Question::Direction(args) => direction::run(args),
        Question::Session(args) => session::run(args),
        Question::Shadow(args) => shadow::run(args),
        Question::Solver(args) => solver::run(args),
        Question::Stress(args) => stress::run(args),
    }
}

/// Makes the folder that pictures go to, where one is wanted: before the work, which takes a while.
fn make_folder(folder: Option<&Path>) -> Result<(), Error> {
    let Some(folder) = folder else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|reason| Error::Unwritable { file: folder.to_owned(), reason })
}

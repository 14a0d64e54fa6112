//! `bendylights bench`: answers to questions that people who run it have, measured.

mod drag;
mod frame;
mod log;
mod session;
mod shadow;

use crate::error::Error;

#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    /// Do drags land, and how long do they take? Random ones, beside the formulas of the BendyLights paper
    Drag(drag::Args),
    /// Where does a frame's time go? Each kind of edit stage by stage, beside other lights and renderers, and how frames grow
    Frame(frame::Args),
    /// How fast is the edit log? Edits acknowledged, undone and replayed a second, and opening time over its length
    Log(log::Args),
    /// How long until an edit is on the screen? Drags a control point over a server of its own, on loopback
    Session(session::Args),
    /// What do bent shadows cost, and how wrong are they? Run time against error of resolution, splitting and filter
    Shadow(shadow::Args),
}

pub fn run(args: &Args) -> Result<(), Error> {
    match &args.question {
        Question::Drag(args) => drag::run(args),
        Question::Frame(args) => frame::run(args),
        Question::Log(args) => log::run(args),
        Question::Session(args) => session::run(args),
        Question::Shadow(args) => shadow::run(args),
    }
}

//! `bendylights bench`: answers to questions that people who run it have, measured.

mod session;

use crate::error::Error;

#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    question: Question,
}

#[derive(clap::Subcommand)]
enum Question {
    /// How long until an edit is on the screen? Drags a control point over a server of its own, on loopback
    Session(session::Args),
}

pub fn run(args: &Args) -> Result<(), Error> {
    match &args.question {
        Question::Session(args) => session::run(args),
    }
}

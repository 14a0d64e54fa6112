//! `bendylights bench log`: measures the speed of commits, undo, replay and opening a session.

use std::path::PathBuf;

use ::bench::log;

use super::{measure, this_program};
use crate::error::Error;
use crate::usage::whole_number_parser;

#[derive(clap::Args)]
#[command(after_help = "\
Grows the log of a server of its own, on loopback, by one client. Prints JSON:
  acknowledgedOneAtATime  edits a second where each waits for the one before; an edit is acknowledged when it is on disk
  acknowledged            with up to 64 under way; undone likewise
  replayed                records a second of `bendylights replay`
  opening                 over the length of the log, milliseconds until the server answers for a session at rest:
                          withoutCheckpointMs, every record replayed; reopenedMs, as the server left it, from its
                          checkpoint once a thousand records have come

Example:
  bendylights bench log -o log.svg")]
pub struct Args {
    /// Edits that the log grows by
    #[arg(long, default_value_t = 10_000, value_name = "N", value_parser = whole_number_parser(1..=1_000_000_u32))]
    edits: u32,
    /// Chart to write: edits a second, and opening time over the length of the log
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let program = this_program()?;
    measure(args.output.as_deref(), |progress| log::run(&program, args.edits as usize, progress)).map(drop)
}

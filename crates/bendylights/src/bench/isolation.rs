//! `bendylights bench neighbours`: measures the effect of one client on another.

use std::path::PathBuf;
use std::time::Duration;

use ::bench::isolation::{self, IsolationRow, ROWS};
use cli::Size;

use super::{measure, this_program};
use crate::error::Error;
use crate::gpu::BackendArgs;
use crate::usage::whole_number_parser;

#[derive(clap::Args)]
#[command(after_help = "\
A victim drags a control point of demo:vases in a view of its own, an update an animation frame, and now and then a feature
of another light with three pins. It does so alone, then while one other client does all it can in sessions of its own, and
alone again once that has gone and all have rested. The other's threads give way, since it would be on another machine. Each row
is another kind of neighbour, with a server of its own:
  nobody             nobody: what the machine itself takes from the victim. Where this misses, no row says anything
  solves             begins drags of features of a light of 258 control points with 256 pins, and gives each up
  solves-in-session  in the victim's session: a slow drag, and edits of its light
  large-views        moves 8 views of 3840x2160
  silent-views       250 views of 1280x720 that are never read, whose light is dragged
  stills-16000, stills-64000, stills-primitives
                     stills of 64x36 of that many triangles, of 100,000 primitives, in one place
  imports            uploads of such scenes
  asks               probes, picks, solved drags, sessions, openapi.json
  resting-views, closing-views
                     30 views of 1280x720 that rest; that are opened and closed
  reads-nothing      64 sockets and 64 requests that read nothing of a document of 16 MiB
  cut-bodies         200 bodies of 8 MiB cut off
  actors             edits, each by another actor
  messages           pings, edits and updates of a drag on 5 sockets
  slow-link          large-views, and the victim's link takes 2 Mbit/s
Prints JSON, for each row:
  passes, missed           which bounds it misses
  share, leastShare        the victim's frames, those that show something new of its drag, over those alone: 0.9 at least,
                           0.45 where the other has much drawn
  longestGapOfUsual        its longest gap over the 95th percentile alone: 4 at most
  ownDragOfUsual           median time of its own drags of features over that alone: 2 at most
  alone, with, aloneAfter  frames, gaps, updates and own drags of the three times
  memory                   of the server: MiB before the other came, at most, and after the rest, 250 more at most
  busyThreads              of the server after the rest: none
  writes                   of actors: bytes written for an edit, twice those of one actor at most
  serverCpuShare, benchCpuShare
                           CPU seconds a second of the server, and of the victim and the other client
  other                    how much the other did, how much of it was answered, and what was refused
Exit code 1 says that a bound is missed. On a machine that does other work meanwhile, bounds may be missed for that.

Examples:
  bendylights bench neighbours -o neighbours.svg > neighbours.json
  bendylights bench neighbours --row large-views --row solves --rest-s 5")]
pub struct Args {
    /// Only this row; may be given more than once
    #[arg(long, value_name = "NAME", value_parser = ROWS.map(|row| row.name))]
    row: Vec<String>,
    /// Seconds that the victim is measured: alone, with the other client, alone again
    #[arg(long, default_value_t = 15, value_name = "S", value_parser = whole_number_parser(1..=600_u64))]
    seconds: u64,
    /// Seconds of rest after the other client has left
    #[arg(long, default_value_t = 60, value_name = "S", value_parser = whole_number_parser(0..=3600_u64))]
    rest_s: u64,
    /// Width and height of the victim's view in pixels
    #[arg(long, default_value = "640x360", value_name = "WxH")]
    size: Size,
    /// Give each socket of the other client an actor of its own, so that nothing but its session tells that it is one
    #[arg(long)]
    many_actors: bool,
    #[command(flatten)]
    backend: BackendArgs,
    /// Program whose `serve` is measured [default: this one]
    #[arg(long, value_name = "PATH")]
    program: Option<PathBuf>,
    /// Chart to write: the victim's share of its frames and its longest gap, a row each
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let program = args.program.clone().map_or_else(this_program, Ok)?;
    let is_wanted = |row: &IsolationRow| args.row.is_empty() || args.row.iter().any(|name| name == row.name);
    let options = isolation::IsolationOptions {
        rows: ROWS.into_iter().filter(is_wanted).collect(),
        size: [args.size.width, args.size.height],
        time: Duration::from_secs(args.seconds),
        rest: Duration::from_secs(args.rest_s),
        many_actors: args.many_actors,
        backend: args.backend.wanted(),
    };
    let report = measure(args.output.as_deref(), |progress| isolation::run(&program, &options, progress))?;
    let rows = report.missed();
    if rows.is_empty() { Ok(()) } else { Err(Error::BoundsMissed { rows: rows.join(", ") }) }
}

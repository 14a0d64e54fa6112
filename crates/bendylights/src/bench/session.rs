//! `bendylights bench session`: how long until an edit is on the screen.

use std::path::PathBuf;
use std::time::Duration;

use ::bench::{session, stills};
use cli::{Output, Size, answer};
use indicatif::{ProgressBar, ProgressStyle};

use crate::error::Error;
use crate::gpu::BackendArgs;

#[derive(clap::Args)]
#[command(after_help = "\
Prints JSON: edit to decoded frame (p50, p95), and where the time of each frame's newest update went:
  wait    from the change to the start of the render
  render  the picture, with its read-back
  encode  JPEG
  send    all else: the update's and the frame's way through sockets and queues
  decode  by the client
Then cases: the same drag in views of 686x382 and 1280x720, alone and while three others watch in views of their own:
frames a second, edit to decoded frame, bytes.

With --stills N another session asks for N pictures meanwhile; prints JSON: frame rate, usual and longest gap of a
drag alone and beside them, how often the one was worked on that was so least often, and when all were there.

Examples:
  bendylights bench session --updates 240 -o session.svg
  bendylights bench session --stills 8 --still-size 4096x4096")]
pub struct Args {
    /// Width and height of the view in pixels
    #[arg(long, default_value = "686x382", value_name = "WxH")]
    size: Size,
    /// Updates of the drag, one an animation frame (1/60 s)
    #[arg(long, default_value_t = 240, value_name = "N", value_parser = clap::value_parser!(u64).range(10..=100_000))]
    updates: u64,
    /// Pictures of 16 samples a pixel that another session asks for meanwhile
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=8), conflicts_with = "output")]
    stills: Option<u64>,
    /// Width and height of those in pixels
    #[arg(long, default_value = "2048x2048", value_name = "WxH", requires = "stills")]
    still_size: Size,
    #[command(flatten)]
    backend: BackendArgs,
    /// Chart to write: a bar a frame, its stages stacked; below it the cases
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if let Some(count) = args.stills {
        return beside_stills(args, count);
    }
    let output = args.output.as_deref().map(Output::create).transpose()?;
    let program = std::env::current_exe().map_err(|error| Error::Bench(error.into()))?;
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} updates").expect("a valid template");
    let bar = ProgressBar::new(args.updates).with_style(style);
    let Size { width, height } = args.size;
    let options = session::Options { width, height, updates: args.updates, backend: args.backend.wanted() };
    let result = session::run(&program, options, |update| bar.set_position(update));
    bar.finish_and_clear();
    let (report, chart) = result.map_err(Error::Bench)?;
    if let Some(output) = output {
        output.write(chart.as_bytes())?;
    }
    Ok(answer(&serde_json::to_string_pretty(&report).expect("plain data with string keys"))?)
}

fn beside_stills(args: &Args, count: u64) -> Result<(), Error> {
    let program = std::env::current_exe().map_err(|error| Error::Bench(error.into()))?;
    let options = stills::Options {
        view: [args.size.width, args.size.height],
        drag: Duration::from_millis(args.updates * 1_000 / 60),
        stills: count as usize,
        still: [args.still_size.width, args.still_size.height],
        samples: 16,
        backend: args.backend.wanted(),
    };
    let report = stills::run(&program, &options).map_err(Error::Bench)?;
    Ok(answer(&serde_json::to_string_pretty(&report).expect("plain data with string keys"))?)
}

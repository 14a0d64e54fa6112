//! `bendylights bench session`: how long until an edit is on the screen.

use std::path::PathBuf;

use ::bench::session;
use indicatif::{ProgressBar, ProgressStyle};

use crate::error::Error;
use crate::output::Output;
use crate::render::Size;

#[derive(clap::Args)]
#[command(after_help = "\
Prints JSON: edit to decoded frame (p50, p95), and where the time of each frame's newest update went:
  wait    from the change to the start of the render
  render  the picture, with its read-back
  encode  JPEG
  send    all else: the update's and the frame's way through sockets and queues
  decode  by the client

Example:
  bendylights bench session --updates 240 -o session.svg")]
pub struct Args {
    /// Width and height of the view in pixels
    #[arg(long, default_value = "686x382", value_name = "WxH")]
    size: Size,
    /// Updates of the drag, one an animation frame (1/60 s)
    #[arg(long, default_value_t = 240, value_name = "N", value_parser = clap::value_parser!(u64).range(10..=100_000))]
    updates: u64,
    /// Chart to write: a bar a frame, its stages stacked
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    let output = args.output.as_deref().map(Output::create).transpose()?;
    let program = std::env::current_exe().map_err(|error| Error::Bench(error.into()))?;
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} updates").expect("a valid template");
    let bar = ProgressBar::new(args.updates).with_style(style);
    let Size { width, height } = args.size;
    let options = session::Options { width, height, updates: args.updates };
    let result = session::run(&program, options, |update| bar.set_position(update));
    bar.finish_and_clear();
    let (report, chart) = result.map_err(Error::Bench)?;
    if let Some(output) = output {
        output.write(chart.as_bytes())?;
    }
    crate::answer(&serde_json::to_string_pretty(&report).expect("plain data with string keys"))
}

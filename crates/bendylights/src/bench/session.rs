//! `bendylights bench session`: measures the time from an edit to its frame on the screen.

use std::path::PathBuf;
use std::time::Duration;

use ::bench::{session, stills};
use cli::Size;

use super::{PeerArgs, measure, name_of, this_program};
use crate::error::Error;
use crate::gpu::BackendArgs;
use crate::render::open_scene_with_lights;
use crate::usage::{print_json, whole_number_parser};

#[derive(clap::Args)]
#[command(after_help = "\
Drags a control point of the scene's first BendyLight in a circle, an update an animation frame. A scene without one has
its first light bent for that, the light that `bendylights bench frame` draws, and the others taken away. Where the
processor lights pictures (--backend) the same drag is measured by wgpu in the same run, directly before and by a server
of its own that has stopped by then. On a machine that does other work meanwhile they do not compare. Prints JSON:
  what     what was dragged
  drags    one a backend, the one that is measured first:
    backend              who drew shadows and lights
    frames, framesPerSecond
    editToDecodedMs      from sending an update to having decoded a frame that shows it: p50, p95
    stagesMs             where the time of each frame's newest update went, p50 and p95 each:
      wait    from the change to the start of the render
      render  the picture, with its read-back
      encode  JPEG
      send    all else: the update's and the frame's way through sockets and queues
      decode  by the client
    releaseToLosslessMs  from letting go to having decoded the lossless picture
    frameBytesP50        of a moving frame
  cases    the same drag, by the first backend, in views of 686x382 and 1280x720, alone and while three others watch in
           views of their own: viewers, framesPerSecond, watchedFramesPerSecond, editToDecoded, frameBytesP50,
           bytesPerSecond
  peers    with --peers, other renderers after the drags, three runs each: name, version, wallMs (min and median of the
           runs' medians), editToDecodedOverIt (the first drag's p50 over that median)

Other renderers are scripts, as `bendylights help bench frame` says. They draw what they draw, in a size of their own
whatever --size says, and neither encode nor send it: name the scene and the size that they draw.

With --stills N another session asks for N pictures meanwhile; prints JSON: frame rate, usual and longest gap of a
drag alone and beside them (alone, beside, rateKept, longestGapOfUsual), how often the one was worked on that was so
least often (leastTurns), how many were there too early (finishedEarly), and when all were (allFinishedS).

Examples:
  bendylights bench session --updates 240 -o session.svg
  bendylights bench session --backend native --scene demo:arbor -o session.svg
  bendylights bench session --scene bench.glb --peers peers --python venv/bin/python -o session.svg > session.json
  bendylights bench session --stills 8 --still-size 4096x4096")]
pub struct Args {
    /// Scene: a glTF file, or `demo:NAME`
    #[arg(long, value_name = "SCENE", default_value = "demo:vases")]
    scene: String,
    /// Width and height of the view in pixels
    #[arg(long, default_value = "686x382", value_name = "WxH")]
    size: Size,
    /// Updates of the drag, one an animation frame (1/60 s)
    #[arg(long, default_value_t = 240, value_name = "N", value_parser = whole_number_parser(10..=100_000_u64))]
    updates: u64,
    /// Pictures of 16 samples a pixel that another session asks for meanwhile
    #[arg(long, value_name = "N", value_parser = whole_number_parser(1..=8_u64), conflicts_with_all = ["output", "scene", "peers"])]
    stills: Option<u64>,
    /// Width and height of those in pixels
    #[arg(long, default_value = "2048x2048", value_name = "WxH", requires = "stills")]
    still_size: Size,
    #[command(flatten)]
    peers: PeerArgs,
    #[command(flatten)]
    backend: BackendArgs,
    /// Chart to write: the drags side by side, a bar a frame, its stages stacked; below them the cases
    #[arg(short, value_name = "OUT.svg")]
    output: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if let Some(count) = args.stills {
        return beside_stills(args, count);
    }
    cli::restart_without_window_system();
    let peers = args.peers.find_peers()?;
    // This check precedes the start of the server, which would refuse the scene later.
    if open_scene_with_lights(&args.scene, None)?.contents.lights.is_empty() {
        return Err(Error::NothingLit(args.scene.clone()));
    }
    let program = this_program()?;
    let options = session::SessionBenchOptions {
        scene: &args.scene,
        name: &name_of(&args.scene),
        width: args.size.width,
        height: args.size.height,
        updates: args.updates,
        backend: args.backend.wanted(),
        peers: peers.as_ref(),
    };
    measure(args.output.as_deref(), |progress| session::run(&program, &options, progress)).map(drop)
}

fn beside_stills(args: &Args, count: u64) -> Result<(), Error> {
    let options = stills::StillsBenchOptions {
        view: [args.size.width, args.size.height],
        drag: Duration::from_millis(args.updates * 1_000 / 60),
        stills: count as usize,
        still: [args.still_size.width, args.still_size.height],
        samples: 16,
        backend: args.backend.wanted(),
    };
    Ok(print_json(&stills::run(&this_program()?, &options)?)?)
}

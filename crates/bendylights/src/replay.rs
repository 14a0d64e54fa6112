//! `bendylights replay`: replays the edits of a log.

use std::path::{Path, PathBuf};
use std::time::Instant;

use cli::{LIMITS, print_answer};
use document::{AssetHash, Document, EditError};
use edit::ReplayError;
use protocol::RenderRequest;
use render::{PictureOrigin, ShadowSettings, ViewSlot};
use scene::Scene;
use store::{Assets, StoreError, visit_log};

use crate::error::Error;
use crate::picture::{PictureArgs, choose_camera};
use crate::picture_files::{OutputPictures, PictureJob};
use crate::render::{draw, left_out};
use crate::resolve::Resolver;
use crate::usage::{print_notes, whole_number_parser};
use crate::{files, known_scenes};

#[derive(clap::Args)]
#[command(after_help = "\
Prints JSON:
  records         records that were replayed
  hash            SHA-256 of the document after them, the same on every machine
  checkpoints_ok  whether every checkpoint on the way says the hash that the document had
  seconds         how long it took
  resolved        with --resolve: how many drags there are (`drags`), how many came to the same light to the last bit
                  (`same`), how far the others' numbers are from the log's at most (`drift`, in the units of positions and
                  radii) and in which record (`drift_seq`), how many were refused (`refused`), and how many another solver
                  or version of it had solved (`other_solver`)

Examples:
  bendylights replay main.jsonl --data bendylights-data --to 120 --render before.png
  bendylights replay main.jsonl --data bendylights-data --render key.exr --camera front --size 1920x1080 --samples 64
  bendylights replay main.jsonl --data bendylights-data --resolve")]
pub struct Args {
    /// Log file that `bendylights export` wrote
    #[arg(value_name = "LOG.jsonl")]
    log: PathBuf,
    /// Data folder with the scenes that --render draws and --resolve drags in; demos are always found
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Last record to replay [default: the last there is]
    #[arg(long, value_name = "N", value_parser = whole_number_parser(0..=u64::MAX))]
    to: Option<u64>,
    /// Solve every drag again, beside what the log has of it
    #[arg(long)]
    resolve: bool,
    /// Picture to draw of the document, as PNG or EXR by its ending
    #[arg(long, value_name = "OUT.png|OUT.exr")]
    render: Option<PathBuf>,
    #[command(flatten)]
    picture: PictureArgs,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if args.render.is_some() {
        cli::restart_without_window_system();
    }
    if args.render.is_none() && !args.picture.is_default() {
        return Err(Error::NoPicture);
    }
    let files = args.render.as_ref().map(|path| args.picture.files(std::slice::from_ref(path))).transpose()?;
    let assets = args.data.as_deref().map(Assets::open).transpose()?;
    let (log, bar) = files::open_log(&args.log)?;
    let start = Instant::now();
    let mut resolver = args.resolve.then(|| Resolver::new(assets.as_ref()));
    let replayed = visit_log(log, args.to, |record, session| {
        if let Some(resolver) = &mut resolver {
            resolver.visit(record, session);
        }
    });
    bar.finish_and_clear();
    let replayed = replayed.map_err(|reason| refused(&args.log, reason))?;
    let document = replayed.session.document();
    let resolved = resolver.map(Resolver::into_json).transpose();
    let resolved = resolved.map_err(|(seq, asset)| no_scene(&args.log, seq, asset))?;
    print_answer(&format!(
        r#"{{"records": {}, "hash": "{}", "checkpoints_ok": {}, "seconds": {:.3}{}}}"#,
        replayed.session.seq(),
        document.hash(),
        replayed.first_difference.is_none(),
        start.elapsed().as_secs_f64(),
        resolved.map_or_else(String::new, |resolved| format!(r#", "resolved": {resolved}"#)),
    ))?;
    if let Some(files) = files {
        let scene = match document.scene() {
            None => Scene::default(),
            Some(scene) => {
                let no_scene = || no_scene(&args.log, replayed.session.seq(), scene.asset);
                known_scenes::load(assets.as_ref(), &scene.asset).ok_or_else(no_scene)?
            }
        };
        draw_document(args, document, replayed.session.seq(), scene, &files)?;
    }
    match replayed.first_difference {
        Some(how) => Err(Error::Differs { file: args.log.display().to_string(), how }),
        None => Ok(()),
    }
}

/// Converts an error of the store about a log file, with advice in terms of the command line.
pub fn refused(log: &Path, reason: StoreError) -> Error {
    match reason {
        StoreError::Replay(ReplayError::Record { seq, reason: EditError::UnknownAsset(asset) }) => {
            no_scene(log, seq, asset)
        }
        StoreError::Io { .. } | StoreError::Database(_) => Error::Store(reason),
        reason => Error::BadLog { file: log.display().to_string(), reason },
    }
}

/// Returns the error that a log needs a scene that is missing.
pub fn no_scene(log: &Path, seq: u64, asset: AssetHash) -> Error {
    Error::NoScene { file: log.display().to_string(), seq, asset }
}

/// Draws the document after record `seq` into files.
fn draw_document(
    args: &Args,
    document: &Document,
    seq: u64,
    scene: Scene,
    files: &OutputPictures,
) -> Result<(), Error> {
    let posed = scene::pose(scene, 0.0);
    let (log, lights) = (args.log.display().to_string(), document.light_instances());
    let request = RenderRequest::from(&args.picture);
    let cameras: Vec<_> = document.cameras().values().cloned().collect();
    let (wanted, aspect) = (request.camera.as_ref(), request.framing_aspect());
    let camera = choose_camera(&log, wanted, aspect, &posed.subject_bounds(), &cameras)?;
    let light = args.picture.choose_light(&log, &log, &lights)?;
    let view = request.view(camera, light, LIMITS, ViewSlot::default());
    print_notes(left_out(&posed.bounds(), &lights).into_iter().chain(args.picture.warning()));
    let origin = PictureOrigin {
        name: Some(log),
        seq: Some(seq),
        document_hash: Some(document.hash().to_string()),
        scene: document.scene().map(|scene| scene.asset.to_string()),
        ..PictureOrigin::default()
    };
    let pictures = PictureJob { view, lights: &lights, wanted: args.picture.wanted(light, &lights), origin };
    draw(&posed, &pictures, ShadowSettings::default(), None, files)
}

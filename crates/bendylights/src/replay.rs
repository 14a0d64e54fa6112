//! `bendylights replay`: a log's edits made again.

use std::path::{Path, PathBuf};
use std::time::Instant;

use cli::{LIMITS, Output, answer, say};
use document::{AssetHash, Document, EditError};
use edit::ReplayError;
use render::{PictureFormat, Renderer, View};
use scene::{DEFAULT_ASPECT, Scene, framing_camera};
use store::{Assets, StoreError, visit_log};

use crate::error::Error;
use crate::render::{left_out, picture_format};
use crate::resolve::Resolver;
use crate::usage::whole;
use crate::{files, gpu, known_scenes};

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
  bendylights replay main.jsonl --data bendylights-data --resolve")]
pub struct Args {
    /// Log file that `bendylights export` wrote
    #[arg(value_name = "LOG.jsonl")]
    log: PathBuf,
    /// Data folder with the scenes that --render draws and --resolve drags in; demos are always found
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Last record to replay [default: the last there is]
    #[arg(long, value_name = "N", value_parser = whole(0..=u64::MAX))]
    to: Option<u64>,
    /// Solve every drag again, beside what the log has of it
    #[arg(long)]
    resolve: bool,
    /// Picture to draw of the document, 640x360 or in the shape of its first camera, from which it looks, as PNG or EXR by its ending
    #[arg(long, value_name = "OUT.png|OUT.exr")]
    render: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if args.render.is_some() {
        cli::without_window_system();
    }
    let picture = args.render.as_deref().map(picture_file).transpose()?;
    let assets = args.data.as_deref().map(scenes_of).transpose()?;
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
    let resolved = resolver.map(Resolver::answer).transpose();
    let resolved = resolved.map_err(|(seq, asset)| no_scene(&args.log, seq, asset))?;
    answer(&format!(
        r#"{{"records": {}, "hash": "{}", "checkpoints_ok": {}, "seconds": {:.3}{}}}"#,
        replayed.session.seq(),
        document.hash(),
        replayed.differs.is_none(),
        start.elapsed().as_secs_f64(),
        resolved.map_or_else(String::new, |resolved| format!(r#", "resolved": {resolved}"#)),
    ))?;
    if let Some((format, output)) = picture {
        let scene = match document.scene() {
            None => Scene::default(),
            Some(scene) => {
                let no_scene = || no_scene(&args.log, replayed.session.seq(), scene.asset);
                known_scenes::load(assets.as_ref(), &scene.asset).ok_or_else(no_scene)?
            }
        };
        output.write(&drawn(document, scene, format)?)?;
    }
    match replayed.differs {
        Some(how) => Err(Error::Differs { file: args.log.display().to_string(), how }),
        None => Ok(()),
    }
}

/// The scenes in a data folder, or in a folder that has nothing but `assets`.
fn scenes_of(data: &Path) -> Result<Assets, Error> {
    if data.is_file() {
        return Err(StoreError::NotAFolder(data.into()).into());
    }
    if !data.join("assets").is_dir() {
        return Err(StoreError::NoData(data.into()).into());
    }
    Ok(Assets::of(data))
}

/// Why a log file is refused, in this program's words where the way out is on its command line.
pub fn refused(log: &Path, reason: StoreError) -> Error {
    match reason {
        StoreError::Replay(ReplayError::Record { seq, reason: EditError::UnknownAsset(asset) }) => {
            no_scene(log, seq, asset)
        }
        StoreError::Io { .. } | StoreError::Database(_) => Error::Store(reason),
        reason => Error::BadLog { file: log.display().to_string(), reason },
    }
}

fn no_scene(log: &Path, seq: u64, asset: AssetHash) -> Error {
    Error::NoScene { file: log.display().to_string(), seq, asset }
}

/// Refuses, before any work is done, what cannot become a picture file.
fn picture_file(path: &Path) -> Result<(PictureFormat, Output), Error> {
    Ok((picture_format(path)?, Output::create(path)?))
}

/// The document from its first camera, or from one that frames its scene.
fn drawn(document: &Document, scene: Scene, format: PictureFormat) -> Result<Vec<u8>, Error> {
    let posed = scene::pose(scene);
    let camera = document.cameras().values().next().cloned();
    let camera = camera.unwrap_or_else(|| framing_camera(&posed.reach(), DEFAULT_ASPECT));
    let size = camera.projection.default_size(LIMITS.max_side);
    let view = View::beauty(camera, size);
    let lights = document.instances();
    for note in left_out(&posed.reach(), &lights) {
        say(&format!("note: {note}"));
    }
    let mut renderer = Renderer::new(gpu::open()?)?;
    renderer.set_scene(&posed)?;
    Ok(renderer.render_file(&view, &lights, format, |_| {})?)
}

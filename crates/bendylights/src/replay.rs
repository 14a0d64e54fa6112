//! `bendylights replay`: a log's edits made again.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use cli::{LIMITS, Output, answer, say};
use document::{Document, EditError};
use edit::ReplayError;
use render::{Gpu, PictureFormat, Renderer, View};
use scene::{DEFAULT_ASPECT, Scene, framing_camera};
use store::{Store, StoreError, replay_log};

use crate::error::Error;
use crate::render::{left_out, picture_format};
use crate::{files, known_scenes};

#[derive(clap::Args)]
#[command(after_help = "\
Prints JSON:
  records         records that were replayed
  hash            SHA-256 of the document after them, the same on every machine
  checkpoints_ok  whether every checkpoint on the way says the hash that the document had
  seconds         how long it took

Example:
  bendylights replay main.jsonl --data bendylights-data --to 120 --render before.png")]
pub struct Args {
    /// Log file that `bendylights export` wrote
    #[arg(value_name = "LOG.jsonl")]
    log: PathBuf,
    /// Data folder with the scene that --render draws; demos are always found
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Last record to replay [default: the last there is]
    #[arg(long, value_name = "N")]
    to: Option<u64>,
    /// Picture to draw of the document, 640x360 or in the shape of its first camera, from which it looks, as PNG or EXR by its ending
    #[arg(long, value_name = "OUT.png|OUT.exr")]
    render: Option<PathBuf>,
}

pub fn run(args: &Args) -> Result<(), Error> {
    if args.render.is_some() {
        cli::without_window_system();
    }
    let picture = args.render.as_deref().map(picture_file).transpose()?;
    let store = args.data.as_deref().map(Store::open).transpose()?;
    let (log, bar) = files::open_log(&args.log)?;
    let start = Instant::now();
    let replayed = replay_log(log, args.to);
    bar.finish_and_clear();
    let replayed = replayed.map_err(|reason| refused(&args.log, reason))?;
    let document = replayed.session.document();
    answer(&format!(
        r#"{{"records": {}, "hash": "{}", "checkpoints_ok": {}, "seconds": {:.3}}}"#,
        replayed.session.seq(),
        document.hash(),
        replayed.differs.is_none(),
        start.elapsed().as_secs_f64(),
    ))?;
    if let Some((format, output)) = picture {
        let scene = match document.scene() {
            None => Scene::default(),
            Some(scene) => {
                let (file, asset) = (args.log.display().to_string(), scene.asset);
                known_scenes::load(store.as_ref(), &asset).ok_or(Error::NoScene {
                    file,
                    seq: replayed.session.seq(),
                    asset,
                })?
            }
        };
        output.write(&drawn(document, scene, format)?)?;
    }
    match replayed.differs {
        Some(seq) => Err(Error::Differs { file: args.log.display().to_string(), seq }),
        None => Ok(()),
    }
}

/// Why a log file is refused, in this program's words where the way out is on its command line.
pub fn refused(log: &Path, reason: StoreError) -> Error {
    let file = log.display().to_string();
    match reason {
        StoreError::Replay(ReplayError::Record { seq, reason: EditError::UnknownAsset(asset) }) => {
            Error::NoScene { file, seq, asset }
        }
        StoreError::Io { .. } | StoreError::Database(_) => Error::Store(reason),
        reason => Error::BadLog { file, reason },
    }
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
    let mut renderer = Renderer::new(Arc::new(Gpu::new()?))?;
    renderer.set_scene(&posed)?;
    Ok(renderer.render_file(&view, &lights, format, |_| {})?)
}

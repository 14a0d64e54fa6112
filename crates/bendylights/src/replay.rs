//! `bendylights replay`: a log's edits made again.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use document::{Document, EditError};
use edit::ReplayError;
use light::Light;
use render::{Gpu, PictureFormat, Renderer, View};
use scene::{DEFAULT_ASPECT, framing_camera};
use store::{Store, StoreError, replay_log};

use crate::error::Error;
use crate::known_scenes::KnownScenes;
use crate::output::{self, Output};
use crate::render::{MAX_SIDE, left_out};
use crate::{answer, files, headless};

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
    /// Data folder with the scenes that the log loads; demos are always found
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
        headless::prepare();
    }
    let picture = args.render.as_deref().map(picture_file).transpose()?;
    let store = args.data.as_deref().map(Store::open).transpose()?;
    let scenes = KnownScenes::new(store);
    let (log, bar) = files::open_log(&args.log)?;
    let start = Instant::now();
    let replayed = replay_log(log, args.to, &|asset| scenes.find(asset));
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
        output.write(&drawn(document, format)?)?;
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
    Ok((output::picture_format(path)?, Output::create(path)?))
}

/// The document from its first camera, or from one that frames its scene.
fn drawn(document: &Document, format: PictureFormat) -> Result<Vec<u8>, Error> {
    let camera = document.cameras().values().next().cloned();
    let camera = camera.unwrap_or_else(|| framing_camera(document.scene(), DEFAULT_ASPECT));
    let size = camera.projection.default_size(MAX_SIDE);
    let view = View::beauty(camera, size);
    let lights: Vec<Light> = document.lights().values().map(|placed| placed.light.clone()).collect();
    for note in left_out(&document.reach(), &lights) {
        crate::say(&format!("note: {note}"));
    }
    let mut renderer = Renderer::new(Arc::new(Gpu::new()?))?;
    renderer.set_scene(document.scene())?;
    Ok(renderer.render_file(&view, &lights, format, |_| {})?)
}

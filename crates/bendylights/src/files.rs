//! Reading of light files, point files, drag files and logs, within limits.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

use cli::progress;
use indicatif::ProgressBar;
use light::CheckedLight;
use protocol::drag_file::{self, FileDrag};
use protocol::point_file::WrittenPoint;
use protocol::{FileError, light_file, point_file};

use crate::error::Error;

/// Maximum size of a light, point or drag file. A million points take about 60 MB.
const MAX_FILE_MIB: u64 = 64;
/// Size of a log that takes about a second to replay. Longer ones show a progress bar.
const LONG_LOG_BYTES: u64 = 4 << 20;
/// First bytes of a .zip file that is not empty.
const ZIP: [u8; 4] = *b"PK\x03\x04";
/// Path that stands for standard input.
const STDIN: &str = "-";

/// Reads the lights of a light file, and checks each.
pub fn read_lights(path: &Path) -> Result<Vec<Arc<CheckedLight>>, Error> {
    let file = path.display().to_string();
    let is_scene = [".glb", ".gltf"].iter().any(|end| file.to_ascii_lowercase().ends_with(end));
    if is_scene || file.starts_with("demo:") {
        return Err(Error::SceneForLight { file });
    }
    let text = File::open(path).and_then(read_limited);
    Ok(parsed(file, text, light_file::parse)?.into_iter().map(Arc::new).collect())
}

/// Reads a light file, which must hold exactly one light.
pub fn read_one_light(path: &Path) -> Result<Arc<CheckedLight>, Error> {
    let mut lights = read_lights(path)?;
    match lights.pop() {
        Some(light) if lights.is_empty() => Ok(light),
        last => {
            let count = lights.len() + usize::from(last.is_some());
            Err(Error::NotOneLight { file: path.display().to_string(), count })
        }
    }
}

/// Reads the world positions of a point file, or of standard input if `path` is `-`.
pub fn read_points(path: &Path) -> Result<Vec<WrittenPoint>, Error> {
    read_file_or_stdin(path, point_file::parse)
}

/// Reads the drags of a drag file, or of standard input if `path` is `-`.
pub fn read_drags(path: &Path) -> Result<Vec<FileDrag>, Error> {
    read_file_or_stdin(path, drag_file::parse)
}

fn read_file_or_stdin<T>(path: &Path, parse: impl Fn(&str) -> Result<T, FileError>) -> Result<T, Error> {
    if path.as_os_str() == STDIN {
        return parsed("standard input".into(), read_limited(io::stdin().lock()), parse);
    }
    parsed(path.display().to_string(), File::open(path).and_then(read_limited), parse)
}

/// Reads all of `source` as text. Returns `None` if it exceeds the limit.
fn read_limited(source: impl Read) -> io::Result<Option<String>> {
    let limit = MAX_FILE_MIB << 20;
    let mut bytes = Vec::new();
    source.take(limit + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > limit {
        return Ok(None);
    }
    String::from_utf8(bytes).map(Some).map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}

fn parsed<T>(
    file: String,
    text: io::Result<Option<String>>,
    parse: impl Fn(&str) -> Result<T, FileError>,
) -> Result<T, Error> {
    match text {
        Err(reason) => Err(Error::Unreadable { file, reason }),
        Ok(None) => Err(Error::TooLarge { file, limit_mib: MAX_FILE_MIB }),
        Ok(Some(text)) => parse(&text).map_err(|reason| Error::BadFile { file, reason }),
    }
}

/// Returns true if the first bytes of the file are those of a bundle.
pub fn is_bundle(path: &Path) -> bool {
    let mut begins = [0; ZIP.len()];
    File::open(path).and_then(|mut file| file.read_exact(&mut begins)).is_ok() && begins == ZIP
}

/// Opens a log file, with a bar that shows the progress of reading on a terminal.
pub fn open_log(path: &Path) -> Result<(BufReader<impl Read>, ProgressBar), Error> {
    if is_bundle(path) {
        return Err(Error::BundleForLog { file: path.display().to_string() });
    }
    let unreadable = |reason| Error::Unreadable { file: path.display().to_string(), reason };
    let file = File::open(path).map_err(unreadable)?;
    let bytes = file.metadata().map_err(unreadable)?.len();
    let bar = match bytes {
        0..LONG_LOG_BYTES => ProgressBar::hidden(),
        _ => progress(bytes),
    };
    Ok((BufReader::new(bar.wrap_read(file)), bar))
}

//! File access of the importer: the scene file, `data:` addresses, and files in the scene's own folder. It
//! reads nothing else.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use data_url::DataUrl;
use gltf::json::Root;

use crate::fault::{excerpt, invalid_gltf};
use crate::limits::{Budget, MAX_MESSAGE_CHARS};
use crate::{AssetFault, ImportLimit};

/// Reads a whole regular file, after a check that its size fits the budget.
pub fn read_file(path: &Path, budget: &mut Budget) -> Result<Vec<u8>, AssetFault> {
    // The check precedes the open, because opening a pipe would block until it has a writer.
    let found = std::fs::metadata(path)?;
    if !found.is_file() {
        return Err(AssetFault::NotAFile);
    }
    let size = found.len();
    budget.spend(ImportLimit::BytesRead, size)?;
    let mut bytes = Vec::new();
    File::open(path)?.take(size).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Returns true if `uri` is a `data:` address.
pub fn is_data(uri: &str) -> bool {
    uri.get(..5).is_some_and(|scheme| scheme.eq_ignore_ascii_case("data:"))
}

/// Returns the bytes at `uri`, relative to the scene file at `scene_file`. Without a scene file only `data:`
/// addresses can be read.
pub fn read(uri: &str, scene_file: Option<&Path>, budget: &mut Budget) -> Result<Vec<u8>, AssetFault> {
    let refuse = |why: String| AssetFault::Address { uri: excerpt(uri, MAX_MESSAGE_CHARS), why };
    if is_data(uri) {
        let decoded = DataUrl::process(uri).ok().and_then(|url| url.decode_to_vec().ok());
        return decoded.map(|(bytes, _)| bytes).ok_or_else(|| refuse("cannot be decoded".into()));
    }
    let name = percent_encoding::percent_decode_str(uri).decode_utf8();
    let name = name.map_err(|_| refuse("is not UTF-8".into()))?;
    stays_inside(&name).map_err(|why| refuse(why.into()))?;

    let scene_file = scene_file.ok_or_else(|| refuse("is not part of it".into()))?;
    let folder = scene_file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let unreadable = |error: std::io::Error| refuse(format!("cannot be read ({error})"));
    let folder = folder.canonicalize().map_err(unreadable)?;
    // Resolves links, so that a link inside the folder cannot lead out of it.
    let path = folder.join(name.as_ref()).canonicalize().map_err(unreadable)?;
    if !path.starts_with(&folder) {
        return Err(refuse("leads out of the scene's folder".into()));
    }
    read_file(&path, budget).map_err(|fault| match fault {
        AssetFault::NotAFile => refuse("is not a regular file".into()),
        AssetFault::Unreadable(error) => unreadable(error),
        other => other,
    })
}

/// Returns an error for every address except a plain relative path that leads downwards. The rules for Windows paths
/// apply on every system, so that a scene that loads on one system loads on all.
fn stays_inside(name: &str) -> Result<(), &'static str> {
    const DEVICES: [&str; 6] = ["con", "prn", "aux", "nul", "conin$", "conout$"];
    if name.contains(':') {
        return Err("is not a file beside the scene");
    }
    if name.contains('\\') || name.starts_with('/') || name.split('/').any(|part| part == "..") {
        return Err("leads out of the scene's folder");
    }
    let is_device = |part: &str| {
        let stem = part.split('.').next().unwrap_or_default().trim_end().to_ascii_lowercase();
        let numbered = stem.strip_prefix("com").or_else(|| stem.strip_prefix("lpt"));
        DEVICES.contains(&stem.as_str()) || numbered.is_some_and(|n| n.len() == 1 && n != "0")
    };
    if name.split('/').any(is_device) || name.chars().any(char::is_control) {
        return Err("names a device");
    }
    Ok(())
}

/// Returns the bytes of every buffer, each at least as long as its declared length.
pub fn buffers<'a>(
    root: &Root,
    bin: Option<&'a [u8]>,
    scene_file: Option<&Path>,
    budget: &mut Budget,
) -> Result<Vec<Cow<'a, [u8]>>, AssetFault> {
    let mut buffers = Vec::new();
    for (index, buffer) in root.buffers.iter().enumerate() {
        let bytes = match (&buffer.uri, bin) {
            (Some(uri), _) => Cow::Owned(read(uri, scene_file, budget)?),
            (None, Some(bin)) if index == 0 => Cow::Borrowed(bin),
            (None, _) => return Err(invalid_gltf(format!("buffer {index} has no data"))),
        };
        let (found, declared) = (bytes.len() as u64, buffer.byte_length.0);
        if found < declared {
            return Err(invalid_gltf(format!("buffer {index} holds {found} bytes but declares {declared}")));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_relative_paths_pass() {
        for inside in ["a.bin", "sub/a.bin", "a..b.bin", "com0.bin", "console.bin", "täst é.png", "./a"] {
            assert_eq!(stays_inside(inside), Ok(()), "{inside}");
        }
        let outside = ["../a", "a/../../b", "/etc/passwd", "..\\a", "file:///a", "http://x/a", "C:a", "NUL", "con.bin"];
        for outside in outside.into_iter().chain(["sub/COM1", "lpt9.txt", "a\0b", "\\\\host\\share"]) {
            assert!(stays_inside(outside).is_err(), "{outside}");
        }
    }

    #[test]
    fn reads_beside_the_scene_and_nowhere_else() {
        let folder = tempfile::tempdir().unwrap();
        let scene_file = folder.path().join("inner/scene.gltf");
        std::fs::create_dir(folder.path().join("inner")).unwrap();
        std::fs::write(folder.path().join("inner/a b.bin"), b"inside").unwrap();
        std::fs::write(folder.path().join("secret.bin"), b"outside").unwrap();
        let read = |uri: &str| super::read(uri, Some(&scene_file), &mut Budget::default());
        assert_eq!(read("a%20b.bin").unwrap(), b"inside");
        assert_eq!(read("data:,hi%20there").unwrap(), b"hi there");
        assert_eq!(read("data:application/octet-stream;base64,aGk=").unwrap(), b"hi");
        for uri in ["%2e%2e/secret.bin", "", ".", "none.bin", "data:;base64,a", "data"] {
            assert!(read(uri).is_err(), "{uri}");
        }
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink("../secret.bin", folder.path().join("inner/link.bin")).unwrap();
            assert!(read("link.bin").unwrap_err().to_string().contains("leads out"));
        }
    }
}

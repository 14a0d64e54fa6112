//! Bundles: .zip files with a session's log and the scenes that it loads.
//!
//! `log.jsonl` is the output of `export`. `assets/HASH` and `assets/HASH.name` are the scenes' files, as in a
//! data folder.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Read, Seek, Write};
use std::path::Path;

use cli::progress;
use document::AssetHash;
use indicatif::ProgressBar;
use store::{Assets, MAX_ASSET_BYTES, SessionRow, Store, StoreError, check_log, visit_log};
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use crate::error::Error;
use crate::{known_scenes, replay};

const LOG: &str = "log.jsonl";
/// Maximum bytes of a scene's name that are read. The store's own limit is lower.
const MOST_NAME_BYTES: u64 = 4096;

/// Returns true if the name of an output file is that of a bundle.
pub fn is_wanted(output: &Path) -> bool {
    output.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("zip"))
}

/// Writes a session's log and the scenes that it loads, except demos.
pub fn write(store: &Store, session: &str, path: &Path, out: &mut (impl Write + Seek)) -> Result<(), Error> {
    let unwritable = |reason| Error::Store(StoreError::Unwritable(reason));
    let mut log = tempfile::tempfile().map_err(unwritable)?;
    let mut buffered = BufWriter::new(&log);
    store.export(session, &mut buffered)?;
    buffered.flush().map_err(unwritable)?;
    drop(buffered);
    log.rewind().map_err(unwritable)?;
    // Scenes, each with the first record that needs it.
    let mut scenes = BTreeMap::new();
    visit_log(BufReader::new(&log), None, |record, session| {
        if let Some(scene) = session.document().scene() {
            scenes.entry(scene.asset).or_insert(record.seq);
        }
    })?;
    log.rewind().map_err(unwritable)?;

    let unzipped = |reason: ZipError| unwritable(reason.into());
    let mut zip = ZipWriter::new(out);
    let options = SimpleFileOptions::default().large_file(true);
    zip.start_file(LOG, options).map_err(unzipped)?;
    io::copy(&mut log, &mut zip).map_err(unwritable)?;
    for (asset, seq) in scenes {
        if known_scenes::is_demo(&asset) {
            continue;
        }
        let bytes = store.assets.bytes(&asset)?.ok_or_else(|| replay::no_scene(path, seq, asset))?;
        zip.start_file(entry(&asset), options).map_err(unzipped)?;
        zip.write_all(&bytes).map_err(unwritable)?;
        if let Some(name) = store.assets.name_of(&asset)? {
            zip.start_file(name_entry(&asset), options).map_err(unzipped)?;
            zip.write_all(name.as_bytes()).map_err(unwritable)?;
        }
    }
    zip.finish().map_err(unzipped)?;
    Ok(())
}

/// Makes a session from a bundle, in a data folder that is created if it is missing. A refused bundle leaves
/// nothing.
pub fn import(path: &Path, data: &Path, name: Option<&str>) -> Result<SessionRow, Error> {
    let file = path.display().to_string();
    let wrong = |reason: ZipError| Error::BadBundle { file: file.clone(), reason: reason.to_string() };
    let opened = File::open(path).map_err(|reason| Error::Unreadable { file: file.clone(), reason })?;
    let mut zip = ZipArchive::new(BufReader::new(opened)).map_err(wrong)?;
    let assets = Assets::in_folder(data);
    let held: BTreeSet<String> =
        zip.file_names().map(|name| Ok(name?.into_owned())).collect::<Result<_, _>>().map_err(wrong)?;
    let needed = RefCell::new(BTreeSet::new());
    let is_in_bundle = |asset: &AssetHash| {
        let is_held = held.contains(&entry(asset));
        if is_held {
            needed.borrow_mut().insert(*asset);
        }
        is_held || known_scenes::is_available(&assets, asset)
    };
    let refused = |reason| replay::refused(path, reason);
    let (log, bar) = open_log(&mut zip).map_err(wrong)?;
    let checked = check_log(log, name, &is_in_bundle);
    bar.finish_and_clear();
    checked.map_err(refused)?;

    let needed = needed.into_inner();
    for asset in &needed {
        let bytes = read(&mut zip, &entry(asset), MAX_ASSET_BYTES).map_err(wrong)?;
        if AssetHash::of(&bytes) != *asset {
            return Err(refused(StoreError::DamagedAsset(*asset)));
        }
    }
    let mut store = Store::create(data)?;
    for asset in &needed {
        store.assets.put(&read(&mut zip, &entry(asset), MAX_ASSET_BYTES).map_err(wrong)?)?;
        if held.contains(&name_entry(asset)) && store.assets.name_of(asset)?.is_none() {
            let name = read(&mut zip, &name_entry(asset), MOST_NAME_BYTES).map_err(wrong)?;
            store.assets.set_name(asset, &String::from_utf8_lossy(&name)).map_err(refused)?;
        }
    }
    let (log, bar) = open_log(&mut zip).map_err(wrong)?;
    let imported = store.import(log, name, &|asset| known_scenes::is_available(&assets, asset));
    bar.finish_and_clear();
    imported.map_err(refused)
}

/// Opens the log in a bundle, with a bar that shows the progress of reading.
fn open_log<R: Read + Seek>(zip: &mut ZipArchive<R>) -> Result<(impl BufRead, ProgressBar), ZipError> {
    let entry = zip.by_name(LOG)?;
    let bar = progress(entry.size());
    Ok((BufReader::new(bar.wrap_read(entry)), bar))
}

/// Reads at most one byte more than `most`, which makes the store refuse a longer file.
fn read<R: Read + Seek>(zip: &mut ZipArchive<R>, name: &str, most: u64) -> Result<Vec<u8>, ZipError> {
    let mut bytes = Vec::new();
    zip.by_name(name)?.take(most + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn entry(asset: &AssetHash) -> String {
    format!("assets/{}", asset.hex())
}

fn name_entry(asset: &AssetHash) -> String {
    format!("assets/{}.name", asset.hex())
}

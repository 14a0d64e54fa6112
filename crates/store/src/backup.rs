//! A copy of the data folder while a server goes on using it.

use std::fs::{self, File, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::StoreError;
use crate::assets::{Assets, check_folder};
use crate::disk::sync_folder;
use crate::sqlite::DatabaseSnapshot;

/// How the name of a folder begins whose backup is not whole yet.
const PARTIAL_PREFIX: &str = ".bendylights-backup-";

/// What a backup holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Backup {
    /// Sessions.
    pub sessions: u64,
    /// Records of all of them.
    pub records: u64,
    /// Scenes, with the files that name them.
    pub files: u64,
    /// Of database and files.
    pub bytes: u64,
}

/// Copies sessions and scenes of the data folder `data` to the folder `to`, which must be missing or empty, and is a data
/// folder then. All of it is on the disk when this returns; where it does not return, or with an error, nothing is at `to`.
///
/// It holds all that was acknowledged before it began: the database as it is at one moment, and the scenes that are there
/// after that, since a scene is on the disk before a record names it. The server's token is not among it. `copied` is told of
/// the bytes of each step and of all.
pub fn back_up(data: &Path, to: &Path, mut copied: impl FnMut(u64, u64)) -> Result<Backup, StoreError> {
    check_folder(data)?;
    let snapshot = DatabaseSnapshot::take(data)?;
    if to.is_file() || fs::read_dir(to).is_ok_and(|mut files| files.next().is_some()) {
        return Err(StoreError::BackupExists(to.into()));
    }
    let unusable = |reason| StoreError::Io { path: to.into(), reason };
    let parent = to.parent().filter(|parent| *parent != "").unwrap_or(Path::new("."));
    fs::create_dir_all(parent).map_err(unusable)?;
    let (folder, _lock) = make_folder(parent).map_err(unusable)?;

    let files = Assets::in_folder(data).files()?;
    let [sessions, records] = snapshot.counts;
    let bytes = snapshot.bytes + files.iter().map(|(_, bytes)| bytes).sum::<u64>();
    snapshot.copy_to(folder.path(), &mut |step| copied(step, bytes))?;
    let assets = Assets::in_folder(folder.path());
    assets.make_folder()?;
    for (file, size) in &files {
        assets.copy_in(file)?;
        copied(*size, bytes);
    }
    assets.sync()?;
    let put = sync_folder(folder.path()).and_then(|()| fs::rename(folder.path(), to));
    put.and_then(|()| sync_folder(parent)).map_err(unusable)?;
    // It has another name now, by which nobody removes it.
    let _ = folder.keep();
    Ok(Backup { sessions, records, files: files.len() as u64, bytes })
}

/// A folder for a backup that is not whole yet, and the lock that says that somebody is at work on it. Those that others have
/// left are removed.
fn make_folder(parent: &Path) -> io::Result<(tempfile::TempDir, File)> {
    // One at a time: a folder that is just made has no lock yet.
    let one_at_a_time = File::open(parent)?;
    one_at_a_time.lock()?;
    for file in fs::read_dir(parent)? {
        let file = file?;
        // One that is whole by now has its own name.
        if file.file_name().to_string_lossy().starts_with(PARTIAL_PREFIX)
            && let Ok(leftover) = File::open(file.path())
            && leftover.try_lock().is_ok()
        {
            fs::remove_dir_all(file.path())?;
        }
    }
    let folder = tempfile::Builder::new()
        .prefix(PARTIAL_PREFIX)
        .permissions(Permissions::from_mode(0o700))
        .tempdir_in(parent)?;
    let lock = File::open(folder.path())?;
    lock.lock()?;
    Ok((folder, lock))
}

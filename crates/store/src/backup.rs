//! Copies of the data folder while a server uses it.

use std::fs::{self, File, Permissions};
use std::io;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::StoreError;
use crate::assets::{Assets, check_folder};
use crate::disk::sync_folder;
use crate::sqlite::DatabaseSnapshot;

/// Prefix of the folder of an unfinished backup.
const PARTIAL_PREFIX: &str = ".bendylights-backup-";

/// Amount of data in a backup.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Backup {
    pub sessions: u64,
    /// Number of records of all sessions.
    pub records: u64,
    /// Number of files of scenes and of scenes' names.
    pub files: u64,
    /// Size of the database and of these files in bytes.
    pub bytes: u64,
}

/// Copies sessions and scenes of the data folder `data` to the folder `to`, which must be missing or empty. Afterwards
/// `to` is a data folder. All of it is on disk when this returns. After an error or a crash nothing is at `to`.
///
/// The backup holds everything acknowledged before it began: a snapshot of the database, and the scenes listed after
/// that. A scene is on disk before a record names it, so none is missing. The backup leaves out the server's token.
/// `copied` receives the bytes of each step and the total.
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
    // The folder has its final name now, so the temporary folder must not be removed on drop.
    let _ = folder.keep();
    Ok(Backup { sessions, records, files: files.len() as u64, bytes })
}

/// Makes the folder of an unfinished backup and takes the lock that marks it as in use. Removes the folders of
/// interrupted backups.
fn make_folder(parent: &Path) -> io::Result<(tempfile::TempDir, File)> {
    // One process at a time, since a new folder is not locked at once.
    let one_at_a_time = File::open(parent)?;
    one_at_a_time.lock()?;
    for file in fs::read_dir(parent)? {
        let file = file?;
        // A completed backup has its final name and does not match the prefix.
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

//! The data folder: one server uses it, and only its owner can read it.

use std::fs::{self, DirBuilder, File, Permissions, TryLockError};
use std::os::unix::fs::{DirBuilderExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

use store::{DATABASE_FILE, FILES, check_folder};

use crate::ServerError;

/// File that locks the folder against a second server.
const LOCK: &str = "lock";

/// Longest wait for the lock, and the time between two tries. A server that is about to end gives the lock up soon, and so
/// does a process between its fork and its exec.
const MAX_WAIT: Duration = Duration::from_millis(500);
const RETRY_AFTER: Duration = Duration::from_millis(20);

/// Makes the folder if it is missing. If it is a data folder, permissions of others are removed, which an earlier
/// version or a copy may have left. The permissions of any other folder stay, and only the server's files are
/// restricted.
pub fn make(folder: &Path) -> Result<(), ServerError> {
    check_folder(folder)?;
    let unusable = |reason| ServerError::Data { path: folder.into(), reason };
    DirBuilder::new().recursive(true).mode(0o700).create(folder).map_err(unusable)?;
    if folder.join(DATABASE_FILE).is_file() {
        restrict_to_owner(folder);
        restrict_to_owner(&folder.join(LOCK));
        for name in FILES {
            restrict_to_owner(&folder.join(name));
        }
    } else if fs::metadata(folder).map_err(unusable)?.permissions().mode() & 0o077 != 0 {
        let folder = folder.display();
        tracing::warn!("{folder}: others may look into this folder, though not read its files: chmod 700 {folder}");
    }
    Ok(())
}

/// Restricts a file or folder to its owner, or logs that the system refuses. Ignores a missing one.
fn restrict_to_owner(path: &Path) {
    let Ok(metadata) = fs::metadata(path) else { return };
    let mode = metadata.permissions().mode() & 0o777;
    let closed = mode & 0o700;
    if mode == closed {
        return;
    }
    let shown_path = path.display();
    match fs::set_permissions(path, Permissions::from_mode(closed)) {
        Ok(()) => tracing::info!("{shown_path}: was open to others (mode {mode:o}) and is no longer"),
        Err(reason) => tracing::warn!("{shown_path}: is open to others (mode {mode:o}): {reason}"),
    }
}

/// Locks the folder while the returned file is open. Gives an error if another server keeps the lock for half a second.
pub fn lock(data: &Path) -> Result<File, ServerError> {
    let path = data.join(LOCK);
    let unusable = |reason| ServerError::Data { path: path.clone(), reason };
    let file = File::options().create(true).truncate(false).write(true).mode(0o600).open(&path).map_err(unusable)?;
    let start = Instant::now();
    loop {
        match file.try_lock() {
            Ok(()) => return Ok(file),
            Err(TryLockError::WouldBlock) if start.elapsed() < MAX_WAIT => thread::sleep(RETRY_AFTER),
            Err(TryLockError::WouldBlock) => return Err(ServerError::Locked(data.into())),
            Err(TryLockError::Error(reason)) => return Err(unusable(reason)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn a_folder_from_before_is_closed_and_any_other_is_left_alone() {
        let parent = tempfile::tempdir().unwrap();
        let (new, other) = (parent.path().join("new"), parent.path().join("other"));
        make(&new).unwrap();
        fs::create_dir(&other).unwrap();
        for folder in [&new, &other] {
            fs::set_permissions(folder, Permissions::from_mode(0o755)).unwrap();
            make(folder).unwrap();
            assert_eq!(mode(folder), 0o755, "it holds nothing of ours");
        }
        for name in [DATABASE_FILE, LOCK] {
            fs::write(new.join(name), "").unwrap();
            fs::set_permissions(new.join(name), Permissions::from_mode(0o644)).unwrap();
        }
        make(&new).unwrap();
        assert_eq!([&new, &new.join(DATABASE_FILE), &new.join(LOCK)].map(|path| mode(path)), [0o700, 0o600, 0o600]);
    }
}

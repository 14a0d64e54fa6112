//! Syncs to disk outside SQLite.

use std::fs::File;
use std::io;
use std::path::Path;

/// Waits until the names in `folder` are on disk, so a new file is found after a power failure.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

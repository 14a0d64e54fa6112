//! What is not SQLite's to see to on the disk.

use std::fs::File;
use std::io;
use std::path::Path;

/// Waits until the names in `folder` are on the disk, so that a file just put there is found after a power cut.
pub fn sync_folder(folder: &Path) -> io::Result<()> {
    File::open(folder)?.sync_all()
}

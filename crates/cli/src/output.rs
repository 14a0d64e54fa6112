//! Output files, which appear whole or not at all.

use std::fs::{File, Permissions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use crate::CliError;

/// File that a command will write. Its path was checked before the work began.
pub struct OutputFile {
    path: PathBuf,
}

impl OutputFile {
    /// Checks, before any work, that a file can be written to `path`.
    pub fn create(path: &Path) -> Result<Self, CliError> {
        let output = Self { path: path.into() };
        if path.is_dir() {
            return Err(output.unwritable(io::ErrorKind::IsADirectory.into()));
        }
        match output.folder().metadata() {
            Ok(folder) if folder.is_dir() => Ok(output),
            Ok(_) => Err(output.unwritable(io::ErrorKind::NotADirectory.into())),
            Err(reason) => Err(output.unwritable(reason)),
        }
    }

    /// Checks the path as `Self::create` does, for a chart, whose file name must end in `.svg`.
    pub fn create_chart(path: &Path) -> Result<Self, CliError> {
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
            return Err(CliError::NoSvg(path.into()));
        }
        Self::create(path)
    }

    /// Writes all bytes of the file.
    pub fn write(&self, bytes: &[u8]) -> Result<(), CliError> {
        self.write_with(|file| file.write_all(bytes).map_err(|reason| self.unwritable(reason)))
    }

    /// Writes to a temporary file in the same folder by `fill`, then renames it, so that a reader never sees
    /// part of a file.
    pub fn write_with<E: From<CliError>>(
        &self,
        fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), E>,
    ) -> Result<(), E> {
        let unwritable = |reason| E::from(self.unwritable(reason));
        // The permissions of any new file, which the umask reduces, not the 0600 of a temporary file.
        let permissions = Permissions::from_mode(0o666);
        let mut file = tempfile::Builder::new()
            .prefix(".bendylights-")
            .permissions(permissions)
            .tempfile_in(self.folder())
            .map_err(unwritable)?;
        let mut writer = BufWriter::new(file.as_file_mut());
        fill(&mut writer)?;
        writer.flush().map_err(unwritable)?;
        drop(writer);
        file.persist(&self.path).map_err(|error| unwritable(error.error))?;
        Ok(())
    }

    fn folder(&self) -> &Path {
        match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        }
    }

    fn unwritable(&self, reason: io::Error) -> CliError {
        CliError::Unwritable { file: self.path.clone(), reason }
    }
}

/// Creates the folder for pictures, if one is given. Call it before the work, which takes long.
pub fn make_folder(folder: Option<&Path>) -> Result<(), CliError> {
    let Some(folder) = folder else { return Ok(()) };
    std::fs::create_dir_all(folder).map_err(|reason| CliError::Unwritable { file: folder.to_owned(), reason })
}

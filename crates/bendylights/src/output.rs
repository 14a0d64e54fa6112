//! Where a command's file goes: it appears whole or not at all.

use std::fs::{File, Permissions};
use std::io::{self, BufWriter, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use render::PictureFormat;

use crate::error::Error;

/// The picture format that the file's name says.
pub fn picture_format(path: &Path) -> Result<PictureFormat, Error> {
    match path.extension().unwrap_or_default().to_ascii_lowercase().to_str() {
        Some("png") => Ok(PictureFormat::Png),
        Some("exr") => Ok(PictureFormat::Exr),
        _ => Err(Error::UnknownFormat(path.into())),
    }
}

/// A file to be written.
pub struct Output {
    path: PathBuf,
}

impl Output {
    /// Refuses, before any work is done, a place that cannot take a file.
    pub fn create(path: &Path) -> Result<Self, Error> {
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

    /// The same for a chart, whose file's name must say that it is an SVG.
    pub fn create_chart(path: &Path) -> Result<Self, Error> {
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("svg")) {
            return Err(Error::NoSvg(path.into()));
        }
        Self::create(path)
    }

    /// Writes the file's bytes.
    pub fn write(&self, bytes: &[u8]) -> Result<(), Error> {
        self.write_with(|file| file.write_all(bytes).map_err(|reason| self.unwritable(reason)))
    }

    /// Has the file written by `fill`, to a file beside it that is then renamed, so that a reader never sees half of it.
    pub fn write_with(
        &self,
        fill: impl FnOnce(&mut BufWriter<&mut File>) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let unwritable = |reason| self.unwritable(reason);
        // As any new file: what the umask leaves of it, not the 0600 of a temporary one.
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

    fn unwritable(&self, reason: io::Error) -> Error {
        Error::Unwritable { file: self.path.clone(), reason }
    }
}

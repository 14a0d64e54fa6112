//! Where a picture goes: the file appears whole or not at all.

use std::fs::Permissions;
use std::io::{self, Cursor, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageFormat};

use crate::error::Error;

/// A picture file to be written.
pub struct Output {
    path: PathBuf,
    format: Format,
}

/// The two formats of pictures.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Eight bits, for people.
    Png,
    /// Linear floats, for programs.
    Exr,
}

impl Output {
    /// Refuses, before any work is done, a name that says no known format and a place that cannot take a file.
    pub fn new(path: &Path) -> Result<Self, Error> {
        let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
        let format = match extension.to_str() {
            Some("png") => Format::Png,
            Some("exr") => Format::Exr,
            _ => return Err(Error::UnknownFormat(path.into())),
        };
        let output = Self { path: path.into(), format };
        if path.is_dir() {
            return Err(output.unwritable(io::ErrorKind::IsADirectory.into()));
        }
        match output.folder().metadata() {
            Ok(folder) if folder.is_dir() => Ok(output),
            Ok(_) => Err(output.unwritable(io::ErrorKind::NotADirectory.into())),
            Err(reason) => Err(output.unwritable(reason)),
        }
    }

    /// The format its name says.
    pub fn format(&self) -> Format {
        self.format
    }

    /// Writes to a file beside it and renames that, so that a reader never sees half a picture.
    pub fn write(&self, picture: &DynamicImage) -> Result<(), Error> {
        let format = match self.format {
            Format::Png => ImageFormat::Png,
            Format::Exr => ImageFormat::OpenExr,
        };
        let mut bytes = Cursor::new(Vec::new());
        picture
            .write_to(&mut bytes, format)
            .map_err(|reason| Error::Encode { file: self.path.clone(), reason })?;
        self.replace(bytes.get_ref()).map_err(|reason| self.unwritable(reason))
    }

    fn replace(&self, bytes: &[u8]) -> io::Result<()> {
        // As any new file: what the umask leaves of it, not the 0600 of a temporary one.
        let permissions = Permissions::from_mode(0o666);
        let mut file = tempfile::Builder::new()
            .prefix(".bendylights-")
            .permissions(permissions)
            .tempfile_in(self.folder())?;
        file.write_all(bytes)?;
        file.persist(&self.path)?;
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

//! Errors of output.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Error of writing an answer or a file.
#[derive(Debug, Error)]
pub enum CliError {
    /// The file name of a chart does not end in `.svg`.
    #[error("{}: charts are SVG; name it OUT.svg", .0.display())]
    NoSvg(PathBuf),
    /// The file cannot be written to its path.
    #[error("{}: cannot be written ({reason}); check the folder and that you may write there", file.display())]
    Unwritable {
        /// Path as given.
        file: PathBuf,
        /// Error of the system.
        reason: io::Error,
    },
    /// Standard output cannot be written.
    #[error("standard output cannot be written ({0}); check where it leads")]
    Stdout(io::Error),
}

impl CliError {
    /// Returns 2 if the user can correct the call, 1 if the machine fails.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::NoSvg(_) | Self::Unwritable { .. } => 2,
            Self::Stdout(_) => 1,
        }
    }
}

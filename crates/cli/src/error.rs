//! Why an answer or a file could not be written.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

/// Why an answer or a file could not be written.
#[derive(Debug, Error)]
pub enum CliError {
    /// A chart whose file name does not say that it is an SVG.
    #[error("{}: charts are SVG; name it OUT.svg", .0.display())]
    NoSvg(PathBuf),
    /// A file that cannot be put where it should go.
    #[error("{}: cannot be written ({reason}); check the folder and that you may write there", file.display())]
    Unwritable {
        /// Its path, as it was given.
        file: PathBuf,
        /// What the system says.
        reason: io::Error,
    },
    /// Standard output would not take the answer.
    #[error("standard output cannot be written ({0}); check where it leads")]
    Stdout(io::Error),
}

impl CliError {
    /// 2 where the user can mend it, 1 where this machine stands in the way.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::NoSvg(_) | Self::Unwritable { .. } => 2,
            Self::Stdout(_) => 1,
        }
    }
}

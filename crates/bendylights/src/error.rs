//! What can go wrong in a command. Every message is one sentence: what is wrong, where, and how to mend it.

use std::io;
use std::path::PathBuf;

use assets::AssetError;
use bendy::LightError;
use protocol::FileError;
use render::RenderError;
use thiserror::Error;

/// Why a command did not do its work.
#[derive(Debug, Error)]
pub enum Error {
    /// A file that the system would not read.
    #[error("{file}: cannot be read ({reason}); check the name and that you may read it")]
    Unreadable { file: String, reason: io::Error },
    /// A light or point file over the limit.
    #[error("{file}: is larger than {limit_mib} MiB; split it")]
    TooLarge { file: String, limit_mib: u64 },
    /// A light or point file that cannot be used.
    #[error("{file}: {reason}")]
    BadFile { file: String, reason: FileError },
    /// A light that cannot be bent as asked.
    #[error("{file}: {reason}")]
    BadLight { file: String, reason: LightError },
    /// A command for one light was given a file with none or several.
    #[error("{file}: holds {count} lights, but this command takes one: keep one in the file")]
    NotOneLight { file: String, count: usize },
    /// `eval` was given a spotlight.
    #[error("{file}: is a spotlight, which has no tube: turn it into one with `bendylights bend` first")]
    EvalOfSpot { file: String },
    /// `bend` was given a BendyLight.
    #[error("{file}: is a BendyLight already: `bendylights bend` takes a light of type `spot`")]
    BendOfBendy { file: String },
    /// A scene file that cannot be used.
    #[error(transparent)]
    Scene(#[from] AssetError),
    /// A name given on the command line is not among those there are.
    #[error("{whose} has no {what} `{name}`: {choices}")]
    NoSuch { whose: String, what: &'static str, name: String, choices: String },
    /// An AOV that shows a light, where there is none.
    #[error("{scene}: has no light to show the {aov} of: name a light file with --lights")]
    NothingToShow { scene: String, aov: &'static str },
    /// A picture whose file name does not say a known format.
    #[error("{}: is neither .png nor .exr; name the picture OUT.png or OUT.exr", .0.display())]
    UnknownFormat(PathBuf),
    /// A picture that cannot be put where it should go.
    #[error("{}: cannot be written ({reason}); check the folder and that you may write there", file.display())]
    Unwritable { file: PathBuf, reason: io::Error },
    /// A picture that its format cannot hold.
    #[error("{}: cannot be encoded ({reason}); try a smaller --size", file.display())]
    Encode { file: PathBuf, reason: image::ImageError },
    /// The renderer could not.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// Standard output would not take the answer.
    #[error("standard output cannot be written ({0}); check where it leads")]
    Stdout(io::Error),
}

impl Error {
    /// 2 where the user can mend it, 1 where this machine stands in the way.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Stdout(_)
            | Self::Render(RenderError::NoAdapter(_) | RenderError::DeviceLost(_) | RenderError::Gpu(_)) => 1,
            _ => 2,
        }
    }
}

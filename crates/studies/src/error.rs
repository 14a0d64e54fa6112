//! Why a study could not be made, or what it found wrong.

use assets::AssetError;
use cli::CliError;
use light::LightError;
use render::RenderError;
use thiserror::Error;

/// Why a study could not be made, or what it found wrong.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The adapter could not do its part.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A light that cannot be evaluated.
    #[error(transparent)]
    Light(#[from] LightError),
    /// A scene could not be read.
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// A property of `stress` does not hold.
    #[error(
        "{count} of the properties do not hold, the first of them `{property}`: the answer has the simplest case of each, \
         and `bendylights-studies stress --only {property} --seed {seed} --cases 1` makes it again"
    )]
    Broken {
        /// Properties that do not hold.
        count: usize,
        /// The name of one.
        property: &'static str,
        /// The seed of its case.
        seed: u64,
    },
    /// An answer or a file could not be written.
    #[error(transparent)]
    Cli(#[from] CliError),
}

impl StudyError {
    /// 2 where the user can mend it, 1 where this machine stands in the way or a study finds the product wrong.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Cli(error) => error.exit_code(),
            Self::Broken { .. }
            | Self::Render(RenderError::NoAdapter(_) | RenderError::DeviceLost(_) | RenderError::Gpu(_)) => 1,
            Self::Render(_) | Self::Light(_) | Self::Asset(_) => 2,
        }
    }
}

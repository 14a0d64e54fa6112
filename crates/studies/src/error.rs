//! Errors of studies.

use assets::AssetError;
use cli::CliError;
use light::LightError;
use render::RenderError;
use thiserror::Error;

/// Reason that a study failed, or the fault that it found.
#[derive(Debug, Error)]
pub enum StudyError {
    /// The GPU or the renderer failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Light(#[from] LightError),
    #[error(transparent)]
    Asset(#[from] AssetError),
    /// A property of `stress` does not hold.
    #[error(
        "{count} of the properties do not hold, the first of them `{property}`: the answer has the simplest case of each, \
         and `bendylights-studies stress --only {property} --seed {seed} --cases 1` makes it again"
    )]
    Broken {
        /// Number of properties that do not hold.
        count: usize,
        /// Name of the first of them.
        property: &'static str,
        /// Seed of its case.
        seed: u64,
    },
    #[error(transparent)]
    Cli(#[from] CliError),
}

impl StudyError {
    /// Returns 2 for errors that the user can correct, and 1 if the machine is not able to run the study or the product
    /// is wrong.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Cli(error) => error.exit_code(),
            Self::Broken { .. }
            | Self::Render(RenderError::NoAdapter(_) | RenderError::DeviceLost(_) | RenderError::Gpu(_)) => 1,
            Self::Render(_) | Self::Light(_) | Self::Asset(_) => 2,
        }
    }
}

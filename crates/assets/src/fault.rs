//! Why a scene was not loaded.

use std::io;

use scene::SceneError;
use thiserror::Error;

use crate::ImportLimit;

/// Why a scene file was not loaded. Reads as one sentence that names the file and the fix.
#[derive(Debug, Error)]
#[error("{file}: {fault}")]
pub struct AssetError {
    /// The scene file, as it was named to [`crate::load`]; "the scene" where it came as bytes.
    pub file: String,
    /// What is wrong with it.
    #[source]
    pub fault: AssetFault,
}

/// What is wrong with a scene file.
#[derive(Debug, Error)]
pub enum AssetFault {
    /// The system would not read it.
    #[error("cannot be read ({0}); check the name and that you may read it")]
    Unreadable(#[from] io::Error),
    /// A folder, a device or a pipe.
    #[error("is not a regular file; name a .gltf or .glb file")]
    NotAFile,
    /// It is not what the glTF 2.0 specification says a file is.
    #[error("is not valid glTF 2.0: {0}; export or copy it again")]
    InvalidGltf(String),
    /// It cannot be drawn without something that this program does not know.
    #[error("{0} is required but not supported: export the scene without it")]
    RequiredExtension(String),
    /// It is larger than is safe to load.
    #[error("{found} {} is over the limit of {}: {}", limit.quantity(), limit.max_value(), limit.fix())]
    Limit {
        /// Which limit.
        limit: ImportLimit,
        /// What the file has, at least.
        found: u64,
    },
    /// It refers to something outside its own folder, or to nothing.
    #[error("refers to '{uri}', which {why}; keep the file beside the scene, or export a .glb")]
    Address {
        /// The address, shortened.
        uri: String,
        /// What is wrong with it.
        why: String,
    },
    /// A picture that cannot be decoded.
    #[error("picture {image} cannot be used: {why}; save it as PNG, JPEG or WebP again")]
    Picture {
        /// Its index in the file.
        image: usize,
        /// What is wrong with it.
        why: String,
    },
    /// Bytes that name a demo scene of another version of this program.
    #[error(
        "is the demo scene '{0}', which this version of the program does not have: use the version that made it"
    )]
    UnknownDemo(String),
    /// The result breaks a promise of the scene document.
    #[error("does not make a sound scene: {0}; export it again")]
    InvalidScene(#[from] SceneError),
}

/// [`AssetFault::InvalidGltf`] for `why`.
pub fn invalid_gltf(why: impl Into<String>) -> AssetFault {
    AssetFault::InvalidGltf(why.into())
}

/// The beginning of a stranger's text, fit to be printed: one line, at most `most` characters.
pub fn excerpt(text: &str, most: usize) -> String {
    let short: String = text.chars().take(most).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if short.len() < text.len() && text.chars().nth(most).is_some() { short + "..." } else { short }
}

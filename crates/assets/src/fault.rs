//! Errors of loading a scene.

use std::io;

use scene::SceneError;
use thiserror::Error;

use crate::ImportLimit;

/// Error of loading a scene file. Its text is one sentence that names the file and the fix.
#[derive(Debug, Error)]
#[error("{file}: {fault}")]
pub struct AssetError {
    /// Path of the scene file, as given to [`crate::load`]; "the scene" for bytes.
    pub file: String,
    #[source]
    pub fault: AssetFault,
}

/// Fault of a scene file.
#[derive(Debug, Error)]
pub enum AssetFault {
    /// The system cannot read the file.
    #[error("cannot be read ({0}); check the name and that you may read it")]
    Unreadable(#[from] io::Error),
    /// The path is a folder, a device or a pipe.
    #[error("is not a regular file; name a .gltf or .glb file")]
    NotAFile,
    /// The file violates the glTF 2.0 specification.
    #[error("is not valid glTF 2.0: {0}; export or copy it again")]
    InvalidGltf(String),
    /// The file requires an extension that this program does not support.
    #[error("{0} is required but not supported: export the scene without it")]
    RequiredExtension(String),
    /// The file exceeds an import limit.
    #[error("{found} {} is over the limit of {}: {}", limit.quantity(), limit.max_value(), limit.fix())]
    Limit {
        limit: ImportLimit,
        /// Amount in the file, or a lower bound of it.
        found: u64,
    },
    /// The file refers to a file outside its own folder, or to one that cannot be read.
    #[error("refers to '{uri}', which {why}; keep the file beside the scene, or export a .glb")]
    Address {
        /// Address in the file, shortened.
        uri: String,
        /// Reason why the address cannot be used.
        why: String,
    },
    /// A picture cannot be decoded.
    #[error("picture {image} cannot be used: {why}; save it as PNG, JPEG or WebP again")]
    Picture {
        /// Index of the picture in the file.
        image: usize,
        /// Reason why the picture cannot be decoded.
        why: String,
    },
    /// The bytes name a demo scene of another version of this program.
    #[error("is the demo scene '{0}', which this version of the program does not have: use the version that made it")]
    UnknownDemo(String),
    /// The imported scene fails its own check.
    #[error("does not make a sound scene: {0}; export it again")]
    InvalidScene(#[from] SceneError),
}

/// Returns [`AssetFault::InvalidGltf`] for `why`.
pub fn invalid_gltf(why: impl Into<String>) -> AssetFault {
    AssetFault::InvalidGltf(why.into())
}

/// Returns the start of untrusted text for a message: one line of at most `most` characters.
pub fn excerpt(text: &str, most: usize) -> String {
    let short: String = text.chars().take(most).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if short.len() < text.len() && text.chars().nth(most).is_some() { short + "..." } else { short }
}

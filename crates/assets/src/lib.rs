//! Reads glTF 2.0 into a [`scene::Scene`], within limits, and makes the procedural demo scenes.
//!
//! A scene file comes from a stranger. So every number in it is checked before it is used, every size is
//! checked before memory is taken (see [`limits`]), and nothing outside the scene's own folder is read.
//! Input never panics; it loads, or an [`AssetError`] says why not and what to do.

mod demo;
mod fault;
mod import;
pub mod limits;
mod notes;

use std::path::Path;

pub use demo::{DEMO_NAMES, demo};
pub use fault::{AssetError, Fault};
pub use limits::Limit;
use scene::Scene;

/// A scene read from a file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The scene; [`Scene::check`] has passed.
    pub scene: Scene,
    /// What a person should know that was left out or changed, one sentence each.
    pub notes: Vec<String>,
}

/// Reads a `.gltf` or `.glb` file and the files beside it that it refers to.
///
/// Units and axes are glTF's: metres, +Y up. Animations, skins and morph targets are left at rest.
pub fn load(path: &Path) -> Result<Loaded, AssetError> {
    import::import(path).map_err(|fault| AssetError { file: path.display().to_string(), fault })
}

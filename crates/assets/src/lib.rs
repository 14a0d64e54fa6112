//! Reads glTF 2.0 into a [`scene::Scene`], within limits, and makes the procedural demo scenes.
//!
//! A scene file comes from a stranger. So every number in it is checked before it is used, every size is
//! checked before memory is taken (see [`limits`]), and nothing outside the scene's own folder is read.
//! [`pack`] makes one file of many, for keeping by its hash.
//! Input never panics; it loads, or an [`AssetError`] says why not and what to do.

mod default_key;
mod demo;
mod example;
mod fault;
mod import;
pub mod limits;
mod notes;

use std::path::Path;

pub use demo::{DEMO_NAMES, demo, demo_bytes};
use document::SceneContents;
pub use example::{example_glb, example_light};
pub use fault::{AssetError, AssetFault};
pub use limits::ImportLimit;
use scene::Scene;

/// A scene read from a file.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// The scene; [`Scene::check`] has passed.
    pub scene: Scene,
    /// The lights and cameras that came with it.
    pub contents: SceneContents,
    /// What the file itself calls it, within [`light::MAX_NAME_BYTES`], where that says more than "Scene"; `demo:NAME` for a
    /// demo.
    pub name: Option<String>,
    /// What a person should know that was left out or changed, one sentence each.
    pub notes: Vec<String>,
}

/// Reads a `.gltf` or `.glb` file and the files beside it that it refers to.
///
/// Units and axes are glTF's: metres, +Y up. Animations, skins and morph targets are left at rest.
pub fn load(path: &Path) -> Result<LoadedScene, AssetError> {
    import::import_file(path).map_err(|fault| AssetError { file: path.display().to_string(), fault })
}

/// Reads a scene from bytes that hold all of it: those of [`pack`], of a `.glb` or self-contained `.gltf`
/// file, or of [`demo_bytes`]. No file is read.
pub fn load_bytes(bytes: &[u8]) -> Result<LoadedScene, AssetError> {
    let loaded = match demo::demo_from_bytes(bytes) {
        Some(demo) => demo,
        None => import::import_bytes(bytes),
    };
    loaded.map_err(|fault| AssetError { file: "the scene".into(), fault })
}

/// The bytes of one file that holds all of a scene on disk.
///
/// A file that refers to no others is taken as it is. Of any other the JSON is, with all that it refers to
/// put in its place as `data:` addresses: pictures that are not drawn, too, so that a later version that
/// draws them finds them. The same files give the same bytes on every machine, and [`load_bytes`] makes of
/// them what [`load`] makes of the files.
pub fn pack(path: &Path) -> Result<Vec<u8>, AssetError> {
    import::pack(path).map_err(|fault| AssetError { file: path.display().to_string(), fault })
}

//! Imports glTF 2.0 into a [`scene::Scene`], within limits, and builds the procedural demo scenes.
//!
//! Scene files come from untrusted sources. The importer checks every number before it uses it, checks every
//! size before it allocates memory (see [`limits`]), and reads nothing outside the scene's own folder. It never
//! panics: an [`AssetError`] names the fault and the fix. [`pack`] turns a scene of several files into one
//! file, which the store keeps by its hash.
//!
//! The crate knows no JSON of the protocol, no renderer and no network.
//!
//! Begin with `load` and `LoadedScene`, then `import/mod.rs` and `import/check.rs`, the first check of a
//! file.

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

/// Imported scene.
#[derive(Clone, Debug)]
pub struct LoadedScene {
    /// Scene that has passed [`Scene::check`].
    pub scene: Scene,
    /// Lights and cameras of the file.
    pub contents: SceneContents,
    /// Name in the file, within [`light::MAX_NAME_BYTES`]; `demo:NAME` for a demo. `None` if the file has none,
    /// or just "Scene".
    pub name: Option<String>,
    /// Notes for people about content that was left out or changed, one sentence each.
    pub notes: Vec<String>,
}

/// Reads a `.gltf` or `.glb` file and the files beside it that it refers to.
///
/// Units and axes are glTF's: metres, +Y up. Animations, skins and morph targets stay in their rest state.
pub fn load(path: &Path) -> Result<LoadedScene, AssetError> {
    import::import_file(path).map_err(|fault| AssetError { file: path.display().to_string(), fault })
}

/// Reads a scene from bytes that hold all of it: those of [`pack`], of a `.glb` or self-contained `.gltf` file,
/// or of [`demo_bytes`]. Reads no file.
pub fn load_bytes(bytes: &[u8]) -> Result<LoadedScene, AssetError> {
    let loaded = match demo::demo_from_bytes(bytes) {
        Some(demo) => demo,
        None => import::import_bytes(bytes),
    };
    loaded.map_err(|fault| AssetError { file: "the scene".into(), fault })
}

/// Returns the bytes of one file that holds a whole scene on disk.
///
/// A file that refers to no others is returned as it is. For any other file the result is its JSON, with all
/// other files embedded as `data:` addresses. Pictures that are not drawn are embedded too, for a later version
/// that draws them. The same files give the same bytes on every machine, and [`load_bytes`] of them gives the
/// same scene as [`load`] of the files.
pub fn pack(path: &Path) -> Result<Vec<u8>, AssetError> {
    import::pack(path).map_err(|fault| AssetError { file: path.display().to_string(), fault })
}

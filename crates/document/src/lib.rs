//! What a session edits: lights, cameras and which scene they light; the commands that edit them.
//!
//! [`changes_of`] turns a [`Command`] into [`Change`]s, [`Document::apply`] makes them, [`Document::hash`] proves them.

mod apply;
mod change;
mod command;
mod document;
mod hash;
mod naming;
mod points;
mod property;

pub use apply::{FindScene, MAX_CAMERAS, MAX_LIGHTS, MAX_NAME_BYTES, changes_of};
pub use change::{Change, EditError};
pub use command::{CameraParameter, Command, LightParameter, PointParameter};
pub use document::{
    AssetHash, CameraId, ControlPoints, Document, Layout, NotAnAssetHash, PlacedLight, SceneRef,
};
pub use hash::DocumentHash;
pub use naming::deed;

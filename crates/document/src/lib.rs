//! What a session edits: lights, cameras, pins and which scene they light; the commands that edit them.
//!
//! A document has no geometry: of the scene it holds the name and the hash of its bytes. [`edited`] turns a [`Command`] into
//! [`Change`]s, [`Document::apply`] makes them, [`Document::hash`] proves them.

mod apply;
mod bending;
mod camera;
mod change;
mod command;
mod document;
mod feature_drag;
mod features;
mod group;
mod hash;
mod named;
mod naming;
mod parameters;
mod pin;
mod pins;
mod points;

pub use apply::{Context, Edited, MAX_CAMERAS, MAX_LIGHTS, edited};
pub use bending::{BENT_SEGMENTS, Bending, axis_reach, resolved};
pub use change::{Change, EditError};
pub use command::{CameraParameter, Command};
pub use document::{
    AssetHash, CameraId, ControlPoints, Document, Layout, NotAnAssetHash, PlacedLight, SceneContents,
    SceneRef,
};
pub use feature_drag::{DragOutcome, FeatureDrag};
pub use features::{MAX_CHOSEN_POINTS, SolvedDrag, solve_drag, solve_drag_within};
pub use group::{EditedTogether, GroupedCommand, edited_together};
pub use hash::{DocumentHash, FIRST_FORMAT_OF_HASH, was_in_format_2};
pub use naming::deed;
pub use parameters::{Target, parameters};
pub use pin::{LightPin, PinId};
pub use pins::MAX_PINS;

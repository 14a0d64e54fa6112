//! What a session edits: lights, cameras, pins and which scene they light; the commands that edit them.
//!
//! A document has no geometry: of the scene it holds the name and the hash of its bytes. [`execute_command`] turns a [`Command`] into
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

pub use apply::{CommandContext, CommandResult, MAX_CAMERAS, MAX_LIGHTS, execute_command};
pub use bending::{BendRequest, DEFAULT_BEND_SEGMENTS, axis_length, fill_in_from_scene};
pub use change::{Change, EditError};
pub use command::{CameraParameter, Command};
pub use document::{
    AssetHash, CameraId, ControlPoints, Document, InvalidAssetHash, NumberedLight, PointNumbering,
    SceneContents, SceneRef,
};
pub use feature_drag::{DragOutcome, FeatureDrag};
pub use features::{MAX_CHOSEN_POINTS, SolvedDrag, solve_drag, solve_drag_budgeted};
pub use group::{GroupResult, GroupedCommand, execute_group};
pub use hash::{DocumentHash, FIRST_FORMAT_OF_HASH, was_in_format_2};
pub use naming::describe_changes;
pub use parameters::{ParameterTarget, parameters};
pub use pin::{LightPin, PinId};
pub use pins::MAX_PINS;

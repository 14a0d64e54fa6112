//! The edited data of a session: lights, cameras, pins and a reference to the scene, with the commands that edit them.
//!
//! A document has no geometry: it holds the name of its scene and the hash of the scene's bytes. [`execute_command`]
//! turns a [`Command`] into [`Change`]s, each of one property with its old and new value. [`Document::apply`] applies
//! changes, and [`Document::hash`] identifies the content. The crate knows no log, no file and no clock. Drags of
//! features, bending, and edits of lights with hard pins take a posed scene from the caller.
//!
//! Begin with [`Command`], [`Change`] and [`Document`], then `apply.rs` (commands into changes), `features.rs` (drags)
//! and `solve.rs` (hard pins).

mod apply;
mod bending;
mod camera;
mod change;
mod command;
mod document;
mod features;
mod group;
mod hash;
mod named;
mod naming;
mod parameters;
mod pin;
mod pins;
mod points;
mod solution;
mod solve;

pub use apply::{CommandContext, CommandResult, MAX_CAMERAS, MAX_LIGHTS, execute_command};
pub use bending::{BendRequest, DEFAULT_BEND_SEGMENTS, axis_length, fill_in_from_scene};
pub use change::{Change, EditError};
pub use command::{CameraParameter, Command};
pub use document::{
    AssetHash, CameraId, ControlPoints, Document, InvalidAssetHash, NumberedLight, PointNumbering, SceneContents,
    SceneRef,
};
pub use drag::DragOutcome;
pub use features::{MAX_CHOSEN_POINTS, check_drag, solve_drag, solve_drag_budgeted};
pub use group::{GroupResult, GroupedCommand, execute_group};
pub use hash::{DocumentHash, FIRST_FORMAT_OF_HASH, was_in_format_2};
pub use naming::describe_changes;
pub use parameters::{ParameterTarget, parameters};
pub use pin::{LightPin, PinId};
pub use pins::MAX_PINS;
pub use solution::{CommandSolution, checks_pins, needs_solution};
pub use solve::solve_command;

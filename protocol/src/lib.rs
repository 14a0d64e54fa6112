//! The one serialised form of BendyLights: light files, documents, commands, records, messages.
//!
//! `SPEC.md` beside this crate's manifest says what they mean. There are two shapes of each thing, this one and the
//! domain's ([`scene`], [`edit`]), and they are converted here and nowhere else. Reading validates: a light that comes out
//! can be evaluated. Numbers keep every bit both ways.

mod checkpoint;
mod code;
mod command;
mod document;
mod error;
mod evaluation;
mod held;
mod http;
mod light;
pub mod light_file;
mod log_file;
mod message;
mod openapi;
pub mod point_file;
mod record;
mod schema;
mod variants;

pub use checkpoint::{LightTouch, PastUndo, Renumbering, SessionCheckpoint};
pub use code::ErrorCode;
pub use command::{CameraParameter, Command, LightParameter, PointParameter};
pub use document::{
    Bounds, Camera, Document, DocumentCamera, DocumentLight, Projection, Quat, SceneRef, Vec3,
};
pub use error::{FileError, Refused};
pub use evaluation::{Evaluation, TubePoint, Visibility};
pub use held::{CompactLine, MIN_HELD_BYTES, Place, compact};
pub use http::{
    Asset, Edit, EditResults, Edits, ErrorBody, NewSession, Problem, SessionEntry, SessionList, SessionState,
};
pub use light::{Bendy, BendyType, Light, Spot, SpotType, Transform};
pub use log_file::{
    Checkpoint, CheckpointLine, FIRST_PROOF, FindLine, LogHeader, LogLine, LogReader, ReadError, next_proof,
};
pub use message::{
    ClientMessage, EditResult, EditStatus, GestureEnd, GestureState, History, HistoryStep, HistorySteps,
    PROTOCOL, Presence, Resync, ServerMessage, Settings, State, ViewSource, Welcome, parse_body,
};
pub use openapi::openapi;
pub use record::{
    Action, Actor, Change, ControlPoints, FORMAT, MAX_RECORD_BYTES, PlacedLight, Record, Scope,
};
pub use schema::{Face, json_schema};

//! The JSON of BendyLights: light files, drag and point files, documents, commands, records, logs and messages.
//!
//! This crate has the only wire types and the only conversions between them and the domain ([`scene`],
//! [`edit`]). A conversion into the domain validates, so a light that results from it can be evaluated. Numbers
//! keep every bit in both directions. JSON Schema and OpenAPI come from the wire types.
//!
//! The crate knows no socket, no HTTP server and no disk. `SPEC.md` beside its manifest says what each message,
//! field and record means.
//!
//! Begin with `Command`, `Record` and `ClientMessage`. `ErrorCode` lists all refusals.

mod checkpoint;
mod code;
mod command;
mod conversion;
mod document;
mod drag;
pub mod drag_file;
mod error;
mod evaluation;
mod format;
mod held;
mod http;
mod light;
pub mod light_file;
mod log_file;
mod log_line;
mod message;
mod openapi;
mod outcome;
mod parameter;
mod parameter_table;
pub mod point_file;
mod probe;
mod record;
mod render_request;
mod schema;
mod stats;
mod variants;
mod vector;
mod words;

pub use self::drag::{
    DocumentPin, Drag, DragAlternative, DragChoice, DragKind, DragLimit, DragOutcome, DragRadii, DragReason,
    DragStatus, Pin, PinKind, PinTarget,
};
pub use self::light::Light;
pub use checkpoint::{LightTouch, PastUndo, Renumbering, SessionCheckpoint};
pub use code::{ErrorCode, Problem};
pub use command::{CameraParameter, Command};
pub use document::{
    Bounds, Camera, Document, DocumentCamera, DocumentLight, Projection, SceneRef, json_around_document,
};
pub use error::{FileError, Refused, from_json as parse_body};
pub use evaluation::{Evaluation, TubePoint, Visibility};
pub use format::FORMAT;
pub use held::{CompactLine, LogPosition, MIN_HELD_BYTES, compact};
pub use http::{
    Asset, DemoScene, DemoScenes, Duplicate, Edit, EditResults, Edits, ErrorBody, LastChange, NewSession, Pick, Picked,
    SceneNodes, SessionChange, SessionEntry, SessionList, SessionState,
};
pub use log_file::{Checkpoint, CheckpointLine, FIRST_PROOF, LogHeader, LogLine, LogReader, next_proof};
pub use log_line::{FindLine, ReadError};
pub use message::{
    ClientMessage, History, HistoryStep, HistorySteps, Interaction, PROTOCOL, Presence, Reduction, Resync,
    ServerMessage, Settings, State, ViewSettings, ViewSource, Welcome,
};
pub use openapi::openapi;
pub use outcome::{Added, Committed, EditResult, GestureState, GestureStatus, Outcome};
pub use parameter::{LightParameter, PointParameter};
pub use parameter_table::{
    Parameter, ParameterChoice, ParameterKind, ParameterOwner, ParameterScale, ParameterTable, ParameterTouches,
    parameter_table,
};
pub use probe::{
    ProbeAnswer, ProbeCamera, ProbeDisabledBy, ProbeRequest, ProbeState, Probed, ProbedCaster, ProbedLight,
    ProbedPlace, ProbedSurface,
};
pub use record::{Action, Actor, Change, ControlPoints, MAX_RECORD_BYTES, PlacedLight, Record, RecordedCommand, Scope};
pub use render_request::{
    Aovs, CameraChoice, RenderBackground, RenderFormat, RenderLimits, RenderParameters, RenderRefusal, RenderRequest,
};
pub use schema::{SchemaSide, json_schema};
pub use stats::{Cause, FrameQuality, FrameStats, Pass, PassRun, TraceLine, TraceWhat};
pub use vector::{Quat, Vec3};

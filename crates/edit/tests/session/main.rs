//! Sessions: requests, undo and redo, gestures, replay.

mod checks;
mod gestures;
mod groups;
mod model;
mod properties;
#[path = "../../../document/tests/editing/random.rs"]
mod random;
mod replay;
mod requests;
mod support;
mod undo;

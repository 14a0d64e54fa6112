//! Studies of the light model, for those who work on it: whether drags land, what they cost, what breaks.
//!
//! They found the decisions of ARCHITECTURE.md and hold them. `bendylights-studies` runs them; they do not ship.

#![expect(clippy::disallowed_methods, reason = "measurements hold within bounds, not to the bit")]

pub mod drags;
mod error;
pub mod stress;
pub mod work;

pub use error::StudyError;

//! Studies of the light model, for those who work on it: which solver, from where light arrives, what breaks.
//!
//! They found the decisions of ARCHITECTURE.md and hold them. `bendylights-studies` runs them; they do not ship.

#![expect(clippy::disallowed_methods, reason = "measurements hold within bounds, not to the bit")]

pub mod direction;
pub mod drags;
mod error;
pub mod solver;
pub mod stress;
mod timing;
pub mod work;

pub use error::StudyError;

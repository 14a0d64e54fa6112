//! Studies of the light model for its developers: the cost of drags (`work`), and numerical stress of the light model
//! and the pictures (`stress`).
//!
//! The studies back decisions of ARCHITECTURE.md and are repeated when those are questioned. The program
//! `bendylights-studies` runs them. They do not ship with `bendylights`, so the crate may use packages that users do
//! not install.
//!
//! The crate knows no server and no edit log. It uses lights, scenes, the drag solver, the renderer and the reference
//! directly, and random drags from `bench`.
//!
//! Begin with `stress::Property` for the list of properties, and `work::search` for the most expensive drag.

#![expect(clippy::disallowed_methods, reason = "measurements hold within bounds, not to the bit")]

mod error;
pub mod stress;
pub mod work;

pub use error::StudyError;

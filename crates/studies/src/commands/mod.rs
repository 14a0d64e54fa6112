//! What each study takes on the command line, and how its answer is written.

pub mod direction;
pub mod drags;
pub mod solver;
pub mod stress;
pub mod work;

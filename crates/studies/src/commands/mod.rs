//! What each study takes on the command line, and how its answer is written.

pub mod drags;
pub mod stress;
pub mod work;

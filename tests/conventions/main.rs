//! Habits of this repository that can be checked.

mod ignored;
#[path = "../sources.rs"]
mod sources;

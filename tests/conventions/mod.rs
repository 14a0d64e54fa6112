//! Habits of this repository that can be checked.

mod docs;
mod ignored;
mod names;

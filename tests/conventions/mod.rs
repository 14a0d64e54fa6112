//! Conventions of this repository that can be tested.

mod docs;
mod ignored;
mod names;

//! How this repository is written, where a habit can be checked.

mod docs;
mod ignored;
mod markdown;
#[path = "../sources.rs"]
mod sources;

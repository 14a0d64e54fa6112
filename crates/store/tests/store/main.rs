//! What the store keeps and what it refuses, on real folders.

mod assets;
mod log_files;
mod records;
mod sessions;
mod support;

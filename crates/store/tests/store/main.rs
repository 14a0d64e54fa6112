//! What the store keeps and what it refuses, on real folders.

mod assets;
mod backup;
mod checkpoints;
mod kills;
mod log_files;
mod operations;
mod records;
mod session_list;
mod sessions;
mod support;

//! Storage and refusals of the store, in real folders.

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

//! The command line, by running the real binary.

mod bad_input;
mod commands;
mod deploy;
mod eval_fixture;
mod help;
mod hostile;
mod logs;
mod precision;
mod program;

//! Tests of the command line with the real binary.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

mod bad_input;
mod bench;
mod commands;
mod deploy;
mod drags;
mod eval_fixture;
mod exr_channels;
mod help;
mod hostile;
mod logs;
mod precision;
mod probes;
mod program;
mod serve;
mod trace;
mod wrong_calls;

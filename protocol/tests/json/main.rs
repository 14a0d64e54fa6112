//! JSON of everything: vectors, round trips, refusals, generated schemas.

mod generated;
mod light_file;
mod log_lines;
mod messages;
mod refusals;
mod round_trip;
mod vectors;

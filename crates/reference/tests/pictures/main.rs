//! Pictures of the reference.

mod light;
mod materials;
mod support;
mod terminator;

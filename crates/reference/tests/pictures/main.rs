//! Tests of the reference's pictures.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

mod idle;
mod light;
mod materials;
mod probe;
mod support;
mod terminator;

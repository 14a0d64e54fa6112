//! The light model against closed forms, finite differences and brute force. Random lights come from proptest, which
//! prints the seed and the shrunk case of a failure.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

mod arc_length;
mod bending;
mod directions;
mod frames;
mod light_coords;
mod lights;
mod parts;
mod profiles;
mod refusals;
mod slab_cover;
mod solver;
mod support;

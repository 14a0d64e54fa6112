//! The light model against closed forms, finite differences and brute force. Random lights come from
//! proptest, which prints the seed and the shrunk case of a failure.

mod arc_length;
mod bending;
mod directions;
mod frames;
mod lights;
mod parts;
mod refusals;
mod slab_cover;
mod solver;

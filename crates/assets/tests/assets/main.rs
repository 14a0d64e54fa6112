//! Scene files by others and by hand: loaded, refused, packed.

mod corpus;
mod hostile;
mod lights;
mod pack;
mod small;
mod support;

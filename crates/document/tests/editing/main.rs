//! Commands, changes and the document's hash.

mod apply;
mod asset_names;
mod cameras;
mod hash;
mod identity;
mod lights;
mod points;
mod properties;
mod random;
mod reach;
mod scenes;
mod support;

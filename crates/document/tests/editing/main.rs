//! Commands, changes and the document's hash.

mod apply;
mod asset_names;
mod bending;
mod cameras;
mod checks;
mod dragging;
mod features;
mod hash;
mod hash_rows;
mod identity;
mod kept_pins;
mod lights;
mod pins;
mod points;
mod properties;
mod random;
mod reach;
mod scenes;
mod support;

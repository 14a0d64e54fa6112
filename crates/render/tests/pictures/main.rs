//! Compares pictures with closed forms. One binary, so that all tests share one device.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

mod antialiasing;
mod bendy_light;
mod caches;
mod display;
mod exposure;
mod fill;
mod layers;
mod links;
mod memory;
mod robustness;
mod spot_light;
mod spot_shadow;
mod straight;
mod support;
mod surface;
mod terminator;
mod tiles;

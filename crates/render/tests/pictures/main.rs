//! Pictures against closed forms. One binary, so that all tests share one device.

mod antialiasing;
mod bendy_light;
mod caches;
mod display;
mod fill;
mod memory;
mod robustness;
mod spot_light;
mod spot_shadow;
mod support;
mod surface;
mod terminator;
mod tiles;

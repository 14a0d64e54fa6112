//! Pictures that the processor lights are those that the graphics device does. One binary, so that all comparisons share
//! one renderer a way.
//!
//! Both start from one G-buffer and draw their own maps. What they share, and what these tests can tell: ARCHITECTURE.md,
//! "The native path".

mod bent;
mod both;
mod straight;
mod threads;

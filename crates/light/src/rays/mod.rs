//! Rays of lights, one module for each shape: they locate a point in a light. [`crate::profile`] has the falloff at the
//! located point, for all shapes alike. Straight and bent rays share no code, so that each can test the other.

pub mod cone;
pub mod omni;
pub mod parallel;
pub mod tube;

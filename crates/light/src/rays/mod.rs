//! How light travels, one module a shape of light: where a point lies in it. What follows from the place is in
//! [`crate::filter`], for all shapes alike. Straight and bent rays share no code, so that each can test the other.

pub mod cone;
pub mod omni;
pub mod parallel;
pub mod tube;

//! Rays against a posed scene, in f64: straight ones for cameras and picks, bent ones for visibility.
//!
//! A [`Bvh`] holds every triangle of a [`scene::PosedScene`] under a bounding-volume hierarchy. All positions are in scene
//! space: world axes, origin at the centre of the scene's bounds, so that no digit is lost wherever the scene stands. [`Bvh::first_hit`] follows a straight ray. [`Bvh::first_bent_hit`] follows light:
//! the curve of constant (v, w) of a BendyLight from its source ([`BentPath`]), which no hierarchy knows; it is
//! cut into chords with a bound on how far each strays from the curve, and what a chord may touch is met with
//! the curve itself. [`Bvh::first_obstacle`] says what stands first in the way of a light of any shape.
//!
//! The same input gives the same bits on every machine.

mod bent_hit;
mod bent_path;
mod bounds;
mod bvh;
mod hierarchy;
mod linked;
mod nearest;
mod obstacle;
mod polyline;
mod seen;
mod solid;
mod straight;
mod triangle;

pub use bent_hit::BentHit;
pub use bent_path::{BentPath, Chord};
pub use bounds::Aabb64;
pub use bvh::Bvh;
pub use linked::LinkedNodes;
pub use nearest::SurfacePoint;
pub use obstacle::{CONTACT_TOLERANCE, LightPath, Obstacle, rounding_error};
pub use polyline::Polyline;
pub use seen::SeenPoint;
pub use straight::Hit;
pub use triangle::Triangle;

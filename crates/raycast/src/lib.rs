//! Rays against a posed scene, in f64: straight rays for cameras and picks, bent rays for visibility.
//!
//! A [`Bvh`] holds every triangle of a [`scene::PosedScene`] under a bounding-volume hierarchy. All positions are in
//! scene space: world axes, origin at the centre of the scene's bounds, so that numbers keep their precision wherever
//! the scene stands. The crate knows no device, no picture and no document. The same input gives the same bits on every
//! machine.
//!
//! Begin with [`Bvh::first_hit`] (straight rays), [`Bvh::first_bent_hit`] (light paths) and [`Bvh::first_obstacle`]
//! (the first caster between a point and a light of any shape).
//!
//! A light path of a BendyLight is the curve of constant (v, w) from its source ([`BentPath`]). A hierarchy cannot be
//! traversed along a curve, so the path is cut into chords with a bound of their error. Triangles that a chord may
//! touch are intersected with the curve itself.

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

//! Scene data: geometry, materials, cameras, node transforms, and views of them.
//!
//! The crate knows no file format, no device and no lights beyond their links and the bounds they are measured against.
//!
//! A [`Scene`] is plain data with public fields. An importer (the `assets` crate, tests) fills it, keeps the promises
//! stated on each field, and calls [`Scene::check`] once to verify them all. `pose` then transforms every vertex into
//! scene space, for renderer, reference and rays alike.
//!
//! Begin with [`Scene`], [`PosedScene`] and [`View`]. [`NodeTree`] has the paths that links use.

mod camera;
mod depth_complexity;
mod node_tree;
mod pose;
mod scene;
mod triangle_hierarchy;
mod view;
mod view_ray;

pub use camera::{Camera, DEFAULT_ASPECT, Projection, framing_camera};
pub use node_tree::{MAX_PATH_BYTES, NodeTree};
pub use pose::{PosedPrimitive, PosedScene, pose, world_bounds};
pub use scene::{Fill, Image, Material, Mesh, Node, Primitive, Sampler, Scene, SceneError, TextureRef, Wrap};
pub use view::{Aov, MapScale, UnknownAov, View, ViewSlot};
pub use view_ray::{ViewRay, pixel_of};

//! What is drawn: geometry, materials, cameras, and where everything stands in the world.
//!
//! A [`Scene`] is plain data with public fields, as importers make it. Whoever makes one (the `assets` crate, tests) keeps
//! the promises stated on each field; [`Scene::check`] verifies them all and is called once by every importer.

mod camera;
mod depth_complexity;
mod node_tree;
mod pose;
mod scene;
mod view;
mod view_ray;

pub use camera::{Camera, DEFAULT_ASPECT, Projection, framing_camera};
pub use node_tree::{MAX_PATH_BYTES, NodeTree};
pub use pose::{PosedPrimitive, PosedScene, pose, world_bounds};
pub use scene::{Fill, Image, Material, Mesh, Node, Primitive, Sampler, Scene, SceneError, TextureRef, Wrap};
pub use view::{Aov, MapScale, UnknownAov, View, ViewSlot};
pub use view_ray::{ViewRay, pixel_of};

//! The scene document: nodes, meshes, materials, cameras and lights, and its pose in world space.
//!
//! Plain data with public fields. Whoever makes a [`Scene`] (the `assets` crate, tests) keeps the promises
//! stated on each field; [`Scene::check`] verifies them all and is called once by every importer.

mod camera;
mod document;
mod pose;

pub use camera::{Camera, Projection, framing_camera, world_bounds};
pub use document::{
    Fill, Image, Light, LightKind, Material, Mesh, Node, Primitive, Sampler, Scene, SceneError, TextureRef,
    Wrap,
};
pub use pose::{PosedPrimitive, pose};

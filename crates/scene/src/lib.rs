//! The document: geometry, materials, cameras and lights; the commands that edit it; its pose in world space.
//!
//! A [`Scene`] is plain data with public fields, as importers make it. Whoever makes one (the `assets` crate, tests) keeps
//! the promises stated on each field; [`Scene::check`] verifies them all and is called once by every importer.
//!
//! A [`Document`] is a scene with the lights and cameras that a session edits. [`changes_of`] turns a
//! [`Command`] into [`Change`]s, [`Document::apply`] makes them, [`Document::hash`] proves them.

mod apply;
mod camera;
mod change;
mod command;
mod document;
mod hash;
mod naming;
mod points;
mod pose;
mod property;
mod reach;
mod scene;
mod view;

pub use apply::{FindScene, MAX_CAMERAS, MAX_LIGHTS, MAX_NAME_BYTES, changes_of};
pub use camera::{Camera, DEFAULT_ASPECT, Projection, framing_camera, world_bounds};
pub use change::{Change, EditError};
pub use command::{CameraParameter, Command, LightParameter, PointParameter};
pub use document::{
    AssetHash, CameraId, ControlPoints, Document, Layout, LightId, NotAnAssetHash, PlacedLight, SceneRef,
};
pub use hash::DocumentHash;
pub use naming::deed;
pub use pose::{PosedPrimitive, pose};
pub use reach::{MAX_EXTENT, OutOfReach, Reach};
pub use scene::{
    Fill, Image, Light, LightKind, Material, Mesh, Node, Primitive, Sampler, Scene, SceneError, TextureRef,
    Wrap,
};
pub use view::{Aov, UnknownAov, View, ViewSlot};

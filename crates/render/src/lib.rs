//! The picture: a headless wgpu renderer of a [`scene::Scene`] under its lights.
//!
//! Geometry is posed once a scene ([`Renderer::set_scene`]) into scene space: world axes, with the origin at
//! the centre of the scene's bounds, so that f32 on the GPU keeps its precision wherever the scene stands. A
//! picture ([`Renderer::render`]) is a G-buffer, a shadow map a light and one additive pass a light. Shadow
//! maps stay while nothing they depend on changes, and so do, for each viewer, its G-buffer and its last
//! picture, as long as there is room ([`Ledger`]).
//!
//! A picture that nobody waits for with a hand on the mouse is drawn in tiles ([`TiledPicture`]), so that other
//! pictures can come between.

mod alpha_test;
mod bendy_light;
mod camera;
mod casters;
mod clusters;
mod coverage;
mod device;
mod display;
mod error;
mod gbuffer;
mod geometry;
mod hierarchy;
mod layout;
mod ledger;
mod lighting;
mod lights;
mod material;
mod mipmap;
mod passes;
mod picture;
mod pipeline;
mod readback;
mod renderer;
mod shaders;
mod shadow;
mod shadow_settings;
mod spot;
mod spot_faces;
mod staged;
mod targets;
mod tile;
mod tiled;
mod warm;

pub use bendy_light::{increasing_roots, locate, map_points};
pub use device::Gpu;
pub use error::RenderError;
pub use ledger::{Ledger, MemoryKind};
pub use picture::{Picture, PictureFormat, Pixels};
pub use renderer::{PassCounts, Renderer, StageTimes};
pub use scene::{Aov, View, ViewSlot};
pub use shadow_settings::{ShadowFilter, ShadowSettings};
pub use tiled::{Progress, TiledPicture};

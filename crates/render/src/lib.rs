//! Draws pictures of a [`scene::Scene`] under its lights: a headless renderer on wgpu.
//!
//! A picture ([`Renderer::render`]) is a G-buffer, one shadow map per light and one additive pass per light. Everything
//! that a picture shares with an earlier one is cached within a [`MemoryBudget`]. Interactive pictures
//! ([`Renderer::render_display`]) sum one cached layer per light, so an edit draws the edited light alone. Other
//! pictures are drawn in tiles ([`TiledPicture`]), so that interactive ones can come between.
//!
//! [`Renderer::set_scene`] uploads geometry in scene space: world axes with the origin at the center of the scene's
//! bounds, so that f32 keeps its precision wherever the scene is.
//!
//! The crate knows no JSON, command line or network. Begin with [`Renderer`], [`Gpu`] and [`Backend`] (GPU or CPU),
//! then the modules `layers` and `lights` (shadow maps).

#![expect(clippy::disallowed_methods, reason = "pictures are held to the reference within bounds, not to the bit")]

mod alpha_test;
mod backend;
mod baked_filter;
mod bendy_light;
mod camera;
mod casters;
mod coarse_casters;
mod compile_pipelines;
mod composite;
mod device;
mod display;
mod driver;
mod error;
mod exr_file;
mod gbuffer;
mod geometry;
mod gpu_scene;
mod gpu_structs;
mod host_scene;
mod layers;
mod lighting;
mod lights;
mod linked;
mod map_key;
mod map_painter;
mod map_source;
mod material;
mod memory;
mod mipmap;
mod native_layers;
mod native_map;
mod native_straight;
mod native_targets;
mod pass_runs;
mod passes;
mod pause;
mod picture;
mod pipeline;
mod position;
mod readback;
mod renderer;
mod shaders;
mod stages;
mod straight;
mod straight_map;
mod targets;
mod tile;
mod tiled;
mod wanted;
mod wgpu_layers;
mod wgpu_maps;

pub use backend::Backend;
pub use bendy_light::{increasing_roots, locate, map_points};
pub use device::Gpu;
pub use error::RenderError;
pub use exr_file::{ExrFile, PictureOrigin};
pub use gpu_scene::SceneOnDevice;
pub use memory::{MemoryBudget, MemoryKind};
pub use pass_runs::{Cause, Pass, PassCounts, PassRun};
pub use picture::{Background, FileNeeds, Picture, Pixels};
pub use relight::{ShadowFilter, YieldPolicy};
pub use renderer::Renderer;
pub use scene::{Aov, MapScale, View, ViewSlot};
pub use shadow::{Culling, ShadowSettings};
pub use stages::{FrameStage, Recording, StageCost, Stopwatch, WorkCounters};
pub use tiled::{SampleProgress, TiledPicture};
pub use wanted::{WantedPicture, wanted_pictures};

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

mod backend;
mod device;
mod error;
mod exposure;
mod exr_file;
mod frame;
mod mipmap;
mod native;
mod picture;
mod probe;
mod renderer;
mod wanted;
mod wgpu;

pub use self::wgpu::Gpu;
pub use backend::Backend;
pub use device::Device;
pub use error::RenderError;
pub use exr_file::{ExrFile, PictureOrigin};
pub use frame::Host;
pub use frame::memory::{MemoryBudget, MemoryKind};
pub use frame::pass_runs::{Cause, Pass, PassCounts, PassRun};
pub use frame::stages::{FrameStage, Recording, StageCost, Stopwatch, WorkCounters};
pub use frame::tiled::SampleProgress;
pub use native::Cpu;
pub use picture::{Background, FileNeeds, Picture, Pixels};
pub use probe::{increasing_roots, locate, map_points};
pub use relight::{ShadowFilter, YieldPolicy};
pub use renderer::{Renderer, SceneOnDevice, TiledPicture};
pub use scene::{Aov, MapScale, View, ViewSlot};
pub use shadow::{Culling, ShadowSettings};
pub use wanted::{WantedPicture, wanted_pictures};

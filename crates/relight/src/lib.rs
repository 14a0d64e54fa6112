//! Relighting on the CPU: shadow maps and light layers in vectorized Rust, on all cores. It is the backend for machines
//! whose graphics device is a software driver.
//!
//! The caller provides a camera ([`CameraRays`]), triangles ([`CasterScene`]) with their materials ([`SurfaceScene`]),
//! the numbers of a light ([`RelitLight`]) and the memory for results. The crate knows no device and no scene. It computes what the shaders of `render`
//! compute, sixteen numbers at a time, on the generic light model of `light`.
//!
//! Begin with `raster.rs` (shadow maps from triangles), `layer.rs` (contribution of a light), `bent/mod.rs`
//! (BendyLights) and `straight/mod.rs` (other shapes).
#![forbid(unsafe_code)]
#![expect(clippy::inline_always, reason = "vectors are only made of what is inlined where the processor was chosen")]

mod alpha_test;
mod aov;
mod attributes;
mod bent;
mod brdf;
mod composite;
mod depth_map;
mod elementary;
mod encoding;
mod lanes;
mod layer;
mod model;
mod nearby;
mod pixel_block;
mod raster;
mod scene;
mod screen;
mod shadow_filter;
mod shape;
mod simd;
mod sixteen;
mod straight;
mod surfaces;
mod texture;
mod transform;
mod visibility;
mod workers;

pub use alpha_test::{AlphaTest, AlphaTests, TexelWrap};
pub use aov::{LightAov, SurfaceAov, add_light_aov, add_surface_aov};
pub use attributes::{MaterialRun, SurfaceMaterial, SurfaceMaterials, SurfaceScene};
pub use bent::{
    BentCasters, BentFace, BentMap, BentMapBuilder, BentMapParams, MapSlab, RelitBent, TubeSpace, Wireframe,
};
pub use composite::{LayerSum, LayerTerm, LayerTerms, add_light, add_sample, display, sum};
pub use depth_map::DepthMap;
pub use layer::{DrawnLight, LightLayer, RelitLight, draw_layer};
pub use pixel_block::CameraRays;
pub use raster::{PicturePart, VisibilityBuffer, VisibilityBuilder, VisibleTriangles};
pub use scene::{CasterHierarchy, CasterLinks, CasterScene};
pub use screen::{Exposure, display_radiance};
pub use shadow_filter::ShadowFilter;
pub use sixteen::{SolverBatch, solve_batch};
pub use straight::{
    AlphaTestedCasters, AlphaTestedRun, DirectionalMapParams, OmniMapParams, OpaqueCasters, RelitDirectional,
    RelitOmni, RelitSpot, SpotMapParams, StraightFace, StraightMap, StraightMapBuilder,
};
pub use surfaces::{FillColors, Surfaces};
pub use texture::{SampledTexture, Texels, Texture};
pub use workers::{Cancelled, Workers, YieldPolicy};

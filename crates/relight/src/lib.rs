//! Relighting on processors: shadow maps and what each light adds to what pixels see, in vectorised Rust on all cores.
//!
//! The second way to light pictures, for machines where the graphics device is a software driver. It starts from
//! a G-buffer that [`Surfaces`] is made of, and knows neither devices nor scenes: whoever calls it brings triangles, a
//! light's numbers and the memory that results go to.
#![forbid(unsafe_code)]
#![expect(
    clippy::inline_always,
    reason = "vectors are only made of what is inlined where the processor was chosen"
)]

mod alpha_test;
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
mod raster;
mod scene;
mod screen;
mod shadow_filter;
mod shape;
mod simd;
mod sixteen;
mod straight;
mod surfaces;
mod visibility;
mod workers;

pub use alpha_test::{AlphaTest, AlphaTests, TexelWrap};
pub use bent::{
    BentCasters, BentFace, BentMap, BentMapBuilder, BentMapParams, MapSlab, RelitBent, TubeSpace,
};
pub use composite::{LayerSum, LayerTerm, LayerTerms, add_light, add_sample, display, sum};
pub use depth_map::DepthMap;
pub use layer::{LightLayer, RelitLight, draw_layer, visibility_of};
pub use scene::{CasterHierarchy, CasterHierarchyNode, CasterLinks, CasterScene};
pub use screen::{Exposure, display_radiance};
pub use shadow_filter::ShadowFilter;
pub use sixteen::{SolverBatch, solve_batch};
pub use straight::{
    AlphaTestedCasters, AlphaTestedRun, DirectionalMapParams, OmniMapParams, RelitDirectional, RelitOmni,
    RelitSpot, SpotMapParams, StraightFace, StraightMap, StraightMapBuilder,
};
pub use surfaces::{CameraRays, FillColors, GbufferRows, Surfaces};
pub use workers::{Cancelled, Workers, YieldPolicy};

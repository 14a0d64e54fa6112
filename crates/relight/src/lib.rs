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

pub use alpha_test::{AlphaTest, AlphaTests, Wrap};
pub use bent::{Bent, BentFace, BentMap, BentMapPlace, BentWork, Casters, Slab, TubeSpace};
pub use composite::{Sum, Term, Terms, add_light, add_sample, display, sum};
pub use depth_map::DepthMap;
pub use layer::{Layer, Light, draw_layer, visibility_of};
pub use scene::{Hierarchy, HierarchyNode, Links, Scene};
pub use screen::{Exposure, display_radiance};
pub use shadow_filter::ShadowFilter;
pub use sixteen::{SixteenCases, roots_of_sixteen};
pub use straight::{
    Directional, DirectionalMapPlace, HoledCasters, HoledRun, Omni, OmniMapPlace, Spot, SpotMapPlace,
    StraightFace, StraightMap, StraightWork,
};
pub use surfaces::{Camera, Fill, Gbuffer, Surfaces};
pub use workers::{Cancelled, Workers, Yielding};

//! The picture as it should be: every pixel in f64, every shadow by following light along its curve.
//!
//! Takes the same scenes, lights and views as the GPU renderer and shares the light model with it, but no line
//! of rendering: no rasteriser, no G-buffer, no shadow map, no tolerance. It is slow, and it is what tests and
//! benchmarks measure errors against.
//!
//! ```
//! use reference::Reference;
//! # let scene = scene::Scene::default();
//! # let camera = scene::framing_camera(&light::Reach::default(), 1.0);
//! let view = scene::View { aov: scene::Aov::Depth, ..scene::View::beauty(camera, [4, 4]) };
//! let frame = Reference::new(scene::pose(scene.clone())).render(&view, &[], || {})?;
//! assert_eq!(frame.pixels[0], [0.0; 4]);
//! # Ok::<(), reference::ReferenceError>(())
//! ```

mod brdf;
mod error;
mod linked;
mod nearest;
mod picture;
mod probe;
mod reference;
mod samples;
mod source;
mod surface;
mod texture;
mod visibility;

pub use brdf::evaluate_brdf;
pub use error::ReferenceError;
pub use linked::LinkedReferenceLight;
pub use picture::ReferencePicture;
pub use probe::{DisabledBy, LightProbe, LightState, Probe, ProbedCaster, ProbedPlace, ProbedSurface};
pub use raycast::LinkedNodes;
pub use reference::Reference;
pub use source::{LightSample, ReferenceLight};
pub use surface::ShadedPoint;

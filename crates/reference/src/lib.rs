//! Reference renderer in f64, and probes of pixels. Tests and benchmarks measure errors against its pictures.
//!
//! It takes the same scenes, lights and views as the GPU renderer, and shares the light model with it, but no
//! code that makes a pixel: no rasterizer, no G-buffer and no shadow map. It traces every shadow along the
//! light path, bent or straight. It is slow. Its only tolerance keeps a surface from shadowing itself.
//!
//! The crate knows nothing of `render`, of files and of JSON.
//!
//! Begin with `Reference`, then `picture.rs` for whole pictures, `probe.rs` for single points and
//! `visibility.rs` for shadows.
//!
//! ```
//! use reference::Reference;
//! # let scene = scene::Scene::default();
//! # let camera = scene::framing_camera(&light::SceneBounds::default(), 1.0);
//! let view = scene::View { aov: scene::Aov::Depth, ..scene::View::beauty(camera, [4, 4]) };
//! let frame = Reference::new(scene::pose(scene.clone(), 0.0)).render(&view, &[], || {})?;
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

//! The BendyLight model: light that travels along a quadratic B-spline inside a tube of varying radius.
//!
//! Pure functions over f64 and f32; knows no scene, no files and no clock. Where this crate says "light
//! model, section n", it means the numbered sections in `ARCHITECTURE.md`. The paper is Kerr, Pellacini and
//! Denning, "BendyLights: Artistic Control of Direct Illumination by Curving Light Rays", 2010; symbols are
//! its own.
//!
//! ```
//! use light::{BendyLight, Tube};
//! use glam::DVec3;
//!
//! let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -2.0)];
//! let tube = Tube::new(&BendyLight::new(points, vec![0.1, 0.4, 0.8]))?;
//! let location = tube.locate(DVec3::new(0.25, 0.0, -1.0));
//! assert!((location.point.expect("inside").t - 0.5).abs() < 1e-12);
//! # Ok::<(), light::LightError>(())
//! ```
#![forbid(unsafe_code)]

mod arc;
mod bend;
mod build;
mod error;
mod light;
mod part;
mod reach;
mod real;
mod segment;
mod slab;
mod solve;
mod tube;
mod validity;
mod warning;

pub use self::light::{
    BendyLight, DEFAULT_CONE_ANGLE, DEFAULT_CONE_SOFTNESS, Decay, Direction, EndMode, Frame, Light, LightId,
    LightKind, SpotLight, Transform,
};
pub use arc::GAUSS_LEGENDRE;
pub use bend::{bend, greville};
pub use build::{MAX_SEGMENTS, Placement, check_spot};
pub use error::LightError;
pub use part::Part;
pub use reach::{MAX_EXTENT, OutOfReach, Reach};
pub use real::Real;
pub use segment::{Segment, TubeBox, quadratic_range};
pub use slab::{Slab, slabs};
pub use solve::{Roots, increasing_roots};
pub use tube::{Location, Profile, Root, Tube, TubePoint};
pub use warning::LightWarning;

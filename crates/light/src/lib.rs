//! The BendyLight model: light that travels along a quadratic B-spline inside a tube of varying radius, and straight
//! lights beside it (spot, omni, directional).
//!
//! The crate has the parameter table, checked lights, splines, frames, tube coordinates, the solver and the irradiance.
//! All are pure functions. They are generic over f64, f32 and many f32 side by side ([`Lanes`]). The crate knows no
//! scene, file or clock.
//!
//! Begin with [`Light`] (a shape and its parameter values), [`CheckedLight`] (one that passed every check), [`Tube`]
//! (evaluation of a BendyLight) and the module `parameters` (the table).
//!
//! "Light model, section n" means the numbered sections in `ARCHITECTURE.md`. The paper is Kerr, Pellacini and Denning,
//! "BendyLights: Artistic Control of Direct Illumination by Curving Light Rays", 2010. Symbols are those of the paper.
//!
//! ```
//! use light::{Light, Tube};
//! use glam::DVec3;
//!
//! let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(1.0, 0.0, -2.0)];
//! let tube = Tube::new(&Light::bendy(points, vec![0.1, 0.4, 0.8]))?;
//! let location = tube.locate(DVec3::new(0.25, 0.0, -1.0));
//! assert!((location.point.expect("inside").t - 0.5).abs() < 1e-12);
//! # Ok::<(), light::LightError>(())
//! ```
#![forbid(unsafe_code)]
#![expect(
    clippy::inline_always,
    reason = "many lanes are only as fast as what is inlined where their width was chosen"
)]

mod arc;
mod bend;
mod build;
mod checked;
mod curve;
mod emission;
mod error;
mod frame;
mod lanes;
mod light;
mod light_coords;
mod links;
mod overlap;
mod parameter;
pub mod parameters;
mod part;
mod periodic_curve;
mod profile;
mod rays;
mod reach;
mod real;
mod revision;
mod segment;
mod slab;
mod solve;
mod validity;
mod warning;

pub use self::light::{
    ControlPoint, CrossSection, Decay, DirectionMode, EndMode, FrameMode, Light, LightId, LightShape, ProfileCurve,
    Transform,
};
pub use arc::GAUSS_LEGENDRE;
pub use bend::{as_spotlight, bend, bend_with_length, greville_abscissae, straighten};
pub use build::{MAX_SEGMENTS, Placement, r_kappa_max_of_segments};
pub use checked::{CheckedLight, LightInstance, LightRays};
pub use curve::{Curve, TubeBox, quadratic_range};
pub use emission::emission;
pub use error::LightError;
pub use frame::perpendicular_up;
pub use lanes::{Lanes, Mask};
pub use light_coords::LightCoords;
pub use links::{Links, MAX_LINK_BYTES, MAX_LINKS};
pub use overlap::TubeOverlap;
pub use parameter::{
    MAX_EXTENT, MAX_NAME_BYTES, NumberRange, Parameter, ParameterChoice, ParameterKey, ParameterKind, ParameterNeeded,
    ParameterNeeds, ParameterOf, ParameterOwner, ParameterScale, ParameterTouches, Setting, Value, ValueStorage,
    ValueType,
};
pub use parameters::{add_parameters, parameter_of, parameters, parameters_of};
pub use part::LightPart;
pub use periodic_curve::{LinearPiece, MAX_KNOTS, PeriodicCurve};
pub use profile::{CrossFalloff, DistanceRamps, EdgeOutline, LightProfile, SectionOutline, blackbody};
pub use rays::cone::Cone;
pub use rays::omni::Omni;
pub use rays::parallel::Parallel;
pub use rays::tube::{RootInTube, Tube, TubeLocation, TubePoint, TubeRoot};
pub use reach::{SceneBounds, UndrawableLight};
pub use real::Real;
pub use revision::{LightDigest, Revisions};
pub use segment::Segment;
pub use slab::{TubeSlab, slabs};
pub use solve::{Roots, increasing_roots};
pub use warning::LightWarning;

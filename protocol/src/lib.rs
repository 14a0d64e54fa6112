//! The one serialised form of BendyLights: what light files, point files and results look like in JSON.
//!
//! There are two shapes of a light, this one and the domain's ([`scene::Light`]), and they are converted here
//! and nowhere else. Reading validates: what [`light_file::parse`] returns can be evaluated. Numbers keep
//! every bit both ways.

mod error;
mod evaluation;
mod light;
pub mod light_file;
pub mod point_file;

pub use error::FileError;
pub use evaluation::{Evaluation, TubePoint};
pub use light::{Bendy, BendyType, Light, Spot, SpotType, Transform};

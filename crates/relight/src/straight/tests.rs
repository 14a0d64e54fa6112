//! Straight lights against the light model in f64, and their maps against shadows with known outlines.

mod faults;
mod holes;
mod places;
mod shadows;

use super::SpotMapParams;
use crate::ShadowFilter;

const SPOT_MAP: SpotMapParams = SpotMapParams {
    near: 0.1,
    mesh_error: 0.0,
    fits: [[0.0, 0.0, 1.0, 1.0]; 5],
    filter: ShadowFilter::Bilinear,
};

//! Straight lights against the light model in f64, and their maps against shadows with known outlines.

mod coordinates;
mod faults;
mod holes;
mod shadows;

use super::{DirectionalMapParams, OmniMapParams, SpotMapParams};
use crate::ShadowFilter;

/// Fit of a face that is drawn as a whole.
const WHOLE: [f32; 4] = [0.0, 0.0, 1.0, 1.0];
const FILTER: ShadowFilter = ShadowFilter::Bilinear;

const SPOT_MAP: SpotMapParams = SpotMapParams { near: 0.1, mesh_error: 0.0, fits: [WHOLE; 5], filter: FILTER };
const OMNI_MAP: OmniMapParams = OmniMapParams { near: 0.1, mesh_error: 0.0, fits: [WHOLE; 6], filter: FILTER };
/// Depths from 0 at z = -3 to 1 at z = 1.
const SUN_MAP: DirectionalMapParams =
    DirectionalMapParams { fit: WHOLE, bottom: -3.0, depth_scale: 0.25, mesh_error: 0.0, filter: FILTER };

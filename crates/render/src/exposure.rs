//! Exposure of radiance for screens.

use relight::Exposure;

/// Limit of exposed radiance, so that it stays finite.
const BRIGHTEST: f32 = 1e30;

/// Converts an exposure in stops.
pub(crate) fn from_stops(stops: f64) -> Exposure {
    let factor = stops.exp2() as f32;
    Exposure { factor, brightest: BRIGHTEST / factor }
}

/// Computes exposed radiance, limited as in the shader.
pub(crate) fn exposed(radiance: f32, Exposure { factor, brightest }: Exposure) -> f32 {
    radiance.min(brightest) * factor
}

//! Exposure of radiance for screens.

/// Limit of exposed radiance, so that it stays finite.
const BRIGHTEST: f32 = 1e30;

/// Factor of radiance, and the radiance that reaches the limit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exposure {
    pub factor: f32,
    pub brightest: f32,
}

impl Exposure {
    /// Converts an exposure in stops.
    pub fn from_stops(stops: f64) -> Self {
        let factor = stops.exp2() as f32;
        Self { factor, brightest: BRIGHTEST / factor }
    }

    /// Computes exposed radiance, limited as in the shader.
    pub fn of(self, radiance: f32) -> f32 {
        radiance.min(self.brightest) * self.factor
    }
}

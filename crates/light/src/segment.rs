//! Segments: a curve with its colour and intensity.

use glam::DVec3;

use crate::lanes::Lanes;
use crate::{Curve, emission};

/// Quadratic segment of a light: its curve, and the Bezier control values of colour and intensity.
#[derive(Clone, Copy, Debug)]
pub struct Segment<F: Lanes> {
    /// Position, radius and frame.
    pub curve: Curve<F>,
    /// Linear RGB.
    pub color: [F::Vec3; 3],
    pub intensity: [F; 3],
    /// Arc length of the centre curve from the source to this segment's start, in tube units.
    pub arc_start: F,
}

impl<F: Lanes> Segment<F> {
    /// Returns the emission at `u`: colour times intensity, linear RGB.
    #[inline(always)]
    pub fn emission(&self, u: F) -> F::Vec3 {
        let w = F::of(1.0) - u;
        let basis = [w * w, F::of(2.0) * w * u, u * u];
        let color = self.color[0] * basis[0] + self.color[1] * basis[1] + self.color[2] * basis[2];
        let intensity = self.intensity[0] * basis[0] + self.intensity[1] * basis[1] + self.intensity[2] * basis[2];
        emission::<F>(color, intensity)
    }
}

impl Segment<f64> {
    /// Converts to f32. Each field is rounded once.
    pub fn to_f32(&self) -> Segment<f32> {
        Segment {
            curve: self.curve.to_f32(),
            color: self.color.map(DVec3::as_vec3),
            intensity: self.intensity.map(|i| i as f32),
            arc_start: self.arc_start as f32,
        }
    }
}

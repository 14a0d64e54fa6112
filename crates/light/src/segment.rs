//! A curve and what it carries.

use glam::DVec3;

use crate::lanes::Lanes;
use crate::{Curve, emission};

/// One quadratic segment of a light: its curve, and the Bezier control values of what varies along it.
#[derive(Clone, Copy, Debug)]
pub struct Segment<F: Lanes> {
    /// Position, radius and frame.
    pub curve: Curve<F>,
    /// Colour, linear RGB.
    pub color: [F::Vec3; 3],
    /// Intensity.
    pub intensity: [F; 3],
    /// Arc length of the centre curve from the source to this segment's start, in tube units.
    pub arc_start: F,
}

impl<F: Lanes> Segment<F> {
    /// What leaves the light at `u`: colour times intensity, linear RGB.
    #[inline(always)]
    pub fn emission(&self, u: F) -> F::Vec3 {
        let w = F::of(1.0) - u;
        let basis = [w * w, F::of(2.0) * w * u, u * u];
        let color = self.color[0] * basis[0] + self.color[1] * basis[1] + self.color[2] * basis[2];
        let intensity =
            self.intensity[0] * basis[0] + self.intensity[1] * basis[1] + self.intensity[2] * basis[2];
        emission::<F>(color, intensity)
    }
}

impl Segment<f64> {
    /// The same segment in f32, each field rounded once.
    pub fn to_f32(&self) -> Segment<f32> {
        Segment {
            curve: self.curve.to_f32(),
            color: self.color.map(DVec3::as_vec3),
            intensity: self.intensity.map(|i| i as f32),
            arc_start: self.arc_start as f32,
        }
    }
}

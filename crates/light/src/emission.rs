//! What leaves a light.

use glam::DVec3;

/// Colour times intensity, neither below zero, linear RGB.
pub fn emission(color: DVec3, intensity: f64) -> DVec3 {
    color.max(DVec3::ZERO) * intensity.max(0.0)
}

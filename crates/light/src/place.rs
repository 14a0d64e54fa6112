//! Where a point lies in a light, whatever the light's shape.

use glam::DVec3;

/// The place of a point in a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Along the light: 0 to the number of segments of a BendyLight, or the share of a spotlight's range (0 without).
    pub t: f64,
    /// Across the light along `v_hat`, in radii.
    pub v: f64,
    /// Across the light along `w_hat`, in radii; the edge is where `v^2 + w^2 = 1`.
    pub w: f64,
    /// Length of the way that light has come from its source, in world units.
    pub s: f64,
    /// Unit vector in world space from the point to where its light comes from.
    pub direction: DVec3,
}

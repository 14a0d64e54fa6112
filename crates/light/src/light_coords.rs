//! Light coordinates of a point, for lights of every shape.

use glam::DVec3;

/// Light coordinates of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCoords {
    /// Coordinate along the light: 0 to the number of segments of a BendyLight, or the share of a light's range (0
    /// without).
    pub t: f64,
    /// Coordinate across the light along `v_hat`: in radii if it has a cone, in half widths of a directional light's
    /// window (0 without), and on the face of a cube about an omni light, from -1 to 1.
    pub v: f64,
    /// Coordinate across the light along `w_hat`, in the same units. The edge of a cone is at `v^2 + w^2 = 1`.
    pub w: f64,
    /// Length of the light path from the source, in world units; 0 if the light comes from infinitely far away.
    pub s: f64,
    /// Unit vector in world space from the point towards the arriving light.
    pub direction: DVec3,
}

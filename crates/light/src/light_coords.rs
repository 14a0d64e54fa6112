//! Where a point lies in a light, whatever the light's shape.

use glam::DVec3;

/// The place of a point in a light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightCoords {
    /// Along the light: 0 to the number of segments of a BendyLight, or the share of a light's range (0 without).
    pub t: f64,
    /// Across the light along `v_hat`: in radii where it has a cone, in halves of a directional light's width (0 without),
    /// and on the face of a cube about an omni light, from -1 to 1.
    pub v: f64,
    /// The same along `w_hat`. A cone's edge is where `v^2 + w^2 = 1`.
    pub w: f64,
    /// Length of the way that light has come from its source, in world units; 0 where it comes from infinitely far away.
    pub s: f64,
    /// Unit vector in world space from the point to where its light comes from.
    pub direction: DVec3,
}

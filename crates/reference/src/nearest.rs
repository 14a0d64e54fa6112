//! The surface that a position was read from.

use glam::DVec3;

use crate::Reference;

impl Reference {
    /// The point of a surface that lies nearest to `point_in_world` and at most `within` world units away, in the
    /// world; holes of alpha-tested materials are no surface.
    ///
    /// A position that was rounded lies above or below the surface it was read from, which then shadows it.
    pub fn surface_near(&self, point_in_world: DVec3, within: f64) -> Option<DVec3> {
        let origin = self.bvh.posed.origin_in_world;
        let solid = |found: &raycast::SurfacePoint| {
            self.bvh.passes_alpha_test(&self.bvh.triangles[found.triangle], found.barycentrics)
        };
        let found = self.bvh.nearest(point_in_world - origin, within, solid)?;
        Some(found.position + origin)
    }
}

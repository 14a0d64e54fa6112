//! Nearest point of a surface.

use glam::DVec3;

use crate::Reference;

impl Reference {
    /// Returns the world position on a surface that is nearest to `point_in_world`, or `None` if none is within
    /// `within` world units. Holes of alpha-tested materials are not part of the surface.
    ///
    /// A rounded position lies slightly above or below its surface, which then would shadow it.
    pub fn surface_near(&self, point_in_world: DVec3, within: f64) -> Option<DVec3> {
        let solid = |found: &raycast::SurfacePoint| {
            self.bvh.passes_alpha_test(&self.bvh.triangle(found.triangle), found.barycentrics)
        };
        let found = self.bvh.nearest(self.in_scene(point_in_world), within, solid)?;
        Some(self.in_world(found.position))
    }
}

//! Search for the surface nearest to a point.

use glam::DVec3;

use crate::Bvh;

/// Point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    pub position: DVec3,
    /// Barycentric weights of the triangle's corners at the point.
    pub barycentrics: DVec3,
}

impl Bvh {
    /// Finds the point of the scene's surfaces nearest to `point`, a position in scene space, at most `within` from it,
    /// that `accept` takes. Of two at the same distance the one with the lower index counts.
    pub fn nearest(&self, point: DVec3, within: f64, accept: impl Fn(&SurfacePoint) -> bool) -> Option<SurfacePoint> {
        self.nearest_budgeted(point, within, |_| true, accept)
    }

    /// Finds the nearest point as `Self::nearest` does, and counts steps as [`Self::first_hit_budgeted`] does.
    pub fn nearest_budgeted(
        &self,
        point: DVec3,
        within: f64,
        spend: impl Fn(u64) -> bool,
        accept: impl Fn(&SurfacePoint) -> bool,
    ) -> Option<SurfacePoint> {
        let mut best: Option<(f64, SurfacePoint)> = None;
        self.hierarchy.visit_near_point(point, within, spend, |index| {
            let triangle = &self.triangle(index);
            if let Some(weights) = triangle.nearest_barycentrics(point) {
                let found =
                    SurfacePoint { triangle: index, position: triangle.position_at(weights), barycentrics: weights };
                let distance = found.position.distance(point);
                let nearer = best.is_none_or(|(least, best)| (distance, index) < (least, best.triangle));
                if distance <= within && nearer && accept(&found) {
                    best = Some((distance, found));
                }
            }
            best.map_or(within, |(distance, _)| distance)
        });
        best.map(|(_, found)| found)
    }
}

//! The surface nearest to a point.

use glam::DVec3;

use crate::Bvh;

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    /// Position in scene space.
    pub position: DVec3,
    /// Weights of the triangle's corners there.
    pub barycentrics: DVec3,
}

impl Bvh {
    /// The point of the scene's surfaces nearest to `point`, a position in scene space, that lies at most `within`
    /// from it and that `accept` takes; of two at the same distance the one of the lower index.
    pub fn nearest(
        &self,
        point: DVec3,
        within: f64,
        accept: impl Fn(&SurfacePoint) -> bool,
    ) -> Option<SurfacePoint> {
        self.nearest_budgeted(point, within, |_| true, accept)
    }

    /// The same by steps that are counted, as of [`Self::first_hit_budgeted`].
    pub fn nearest_budgeted(
        &self,
        point: DVec3,
        within: f64,
        spend: impl Fn(u64) -> bool,
        accept: impl Fn(&SurfacePoint) -> bool,
    ) -> Option<SurfacePoint> {
        let mut best: Option<(f64, SurfacePoint)> = None;
        self.hierarchy.visit_near_point(point, within, spend, |index| {
            let triangle = &self.triangles[index];
            if let Some(weights) = triangle.nearest_barycentrics(point) {
                let found = SurfacePoint {
                    triangle: index,
                    position: triangle.position_at(weights),
                    barycentrics: weights,
                };
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

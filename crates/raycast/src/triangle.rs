//! Triangles in scene space.

use glam::DVec3;

/// Triangle in scene space, with its origin in the scene.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Positions, counter-clockwise seen from the front, also on mirrored nodes.
    pub corners: [DVec3; 3],
    pub node: usize,
    /// Index of the triangle's primitive in [`scene::PosedScene::primitives`].
    pub primitive: usize,
    /// Indices of the triangle's vertices in that primitive, in the order of `corners`.
    pub vertices: [u32; 3],
}

/// Distance outside an edge within which a triangle is still hit, as a share of its height over the edge. Adjacent
/// triangles overlap by that, so that rounding, 2e-16 times some tens, opens no crack between them.
const OVERLAP: f64 = 1e-12;

impl Triangle {
    /// Returns the normal towards the front, with twice the area as its length; zero for a triangle without area.
    pub fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a)
    }

    /// Returns the barycentric weights of the corners at a point of the triangle's plane, inside the triangle or not;
    /// NaN for a triangle without area.
    pub fn plane_barycentrics(&self, point: DVec3) -> DVec3 {
        let [a, b, c] = self.corners;
        let (normal, at) = (self.normal(), point - a);
        let area2 = normal.length_squared();
        let (beta, gamma) = (at.cross(c - a).dot(normal) / area2, (b - a).cross(at).dot(normal) / area2);
        DVec3::new(1.0 - beta - gamma, beta, gamma)
    }

    /// Returns the barycentric weights of the corners at a point of the triangle's plane; `None` outside the triangle.
    pub fn barycentrics_at(&self, point: DVec3) -> Option<DVec3> {
        let weights = self.plane_barycentrics(point);
        // Also false for a triangle without area, for which all is NaN.
        (weights.min_element() >= -OVERLAP).then_some(weights)
    }

    /// Returns the barycentric weights of the triangle's point nearest to `point`; `None` for a triangle without area.
    pub fn nearest_barycentrics(&self, point: DVec3) -> Option<DVec3> {
        let [a, b, c] = self.corners;
        let normal = self.normal();
        let foot = point - normal * ((point - a).dot(normal) / normal.length_squared());
        if let Some(weights) = self.barycentrics_at(foot) {
            return Some(weights);
        }
        // Outside the triangle the nearest point lies on an edge.
        let on_edge =
            |from: DVec3, to: DVec3| ((point - from).dot(to - from) / (to - from).length_squared()).clamp(0.0, 1.0);
        let (ab, bc, ca) = (on_edge(a, b), on_edge(b, c), on_edge(c, a));
        let edges = [[1.0 - ab, ab, 0.0], [0.0, 1.0 - bc, bc], [ca, 0.0, 1.0 - ca]].map(DVec3::from);
        let distance2 = |weights: &DVec3| self.position_at(*weights).distance_squared(point);
        let nearest = edges.into_iter().min_by(|x, y| distance2(x).total_cmp(&distance2(y)));
        nearest.filter(|_| normal != DVec3::ZERO)
    }

    /// Returns the position at barycentric weights.
    pub fn position_at(&self, weights: DVec3) -> DVec3 {
        let [a, b, c] = self.corners;
        a * weights.x + b * weights.y + c * weights.z
    }
}

//! Surface points that a camera sees.

use glam::DVec3;
use scene::ViewRay;

use crate::Bvh;

/// Surface point that a camera sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenPoint {
    /// Position in scene space: world axes, about [`scene::PosedScene::origin_in_world`].
    pub position: DVec3,
    /// Distance along the view axis, in world units.
    pub depth: f64,
    /// Unit normal of the triangle, towards the viewer.
    pub geometric_normal: DVec3,
    /// Unit shading normal, interpolated between the vertices, on the viewer's side of the triangle.
    pub normal: DVec3,
    /// Offset along `normal` from `position` to the point whose shadow counts, in world units, 0 or more. See
    /// [`Self::shadow_position`].
    pub terminator_offset: f64,
    pub to_eye: DVec3,
    pub node: usize,
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    /// Barycentric weights of the triangle's corners.
    pub barycentrics: DVec3,
}

impl SeenPoint {
    /// Returns the point in scene space at which visibility of the light is evaluated. It lies in front of the triangle
    /// by the height of the smooth surface that the vertex normals describe, so that facets do not shadow each other at
    /// grazing light.
    ///
    /// `P + h n`, `h = sum b_i |(p_i - P) . (n_i - m)|` over the corners `p_i` with their normals `n_i` and the point's
    /// weights `b_i`, `m = sum b_i n_i` and n its direction. After Hanika, "Hacking the Shadow Terminator" (Ray Tracing
    /// Gems II, chapter 4). Where the surface is convex, this is his offset: on a ball twice its height over the facet.
    /// Two things differ. He offsets nothing where the surface is concave, and then a saddle, as at the neck of a vase,
    /// keeps its jagged terminator. And he has no m, which removes the lean that all normals share, as those of leaves
    /// may.
    pub fn shadow_position(&self) -> DVec3 {
        self.position + self.normal * self.terminator_offset
    }

    /// Returns the unit vector towards a light whose mirror reflection here reaches the viewer.
    pub fn mirror_direction(&self) -> DVec3 {
        self.normal * (2.0 * self.normal.dot(self.to_eye)) - self.to_eye
    }
}

impl Bvh {
    /// Finds the first surface on a ray of a camera. Back faces count if the material is double-sided. Cut-out parts of
    /// an alpha-tested material do not count. `None` for the background.
    pub fn visible_point(&self, ray: &ViewRay) -> Option<SeenPoint> {
        self.visible_point_budgeted(ray, |_| true)
    }

    /// Finds the first visible surface as `Self::visible_point` does, and counts steps as
    /// [`Self::first_hit_budgeted`] does.
    pub fn visible_point_budgeted(&self, ray: &ViewRay, spend: impl Fn(u64) -> bool) -> Option<SeenPoint> {
        let hit = self.first_hit_budgeted(ray.origin, ray.direction, ray.depth_range, spend, |hit| {
            let triangle = &self.triangle(hit.triangle);
            let front = triangle.normal().dot(ray.direction) < 0.0;
            (front || self.material(triangle).double_sided) && self.passes_alpha_test(triangle, hit.barycentrics)
        })?;
        let triangle = &self.triangle(hit.triangle);
        let face = triangle.normal().normalize();
        let side = if face.dot(ray.direction) < 0.0 { 1.0 } else { -1.0 };
        let position = ray.origin + ray.direction * hit.distance;
        let (normal, terminator_offset) = self.smooth_surface_at(hit.triangle, hit.barycentrics, position);
        Some(SeenPoint {
            position,
            depth: hit.distance,
            geometric_normal: face * side,
            normal: normal * side,
            terminator_offset,
            to_eye: -ray.direction.normalize(),
            node: triangle.node,
            triangle: hit.triangle,
            barycentrics: hit.barycentrics,
        })
    }

    /// Evaluates the smooth surface that the vertex normals of a triangle describe, at a position with those
    /// barycentric weights. Returns its unit normal on the triangle's front and [`SeenPoint::terminator_offset`].
    pub fn smooth_surface_at(&self, triangle: usize, weights: DVec3, position: DVec3) -> (DVec3, f64) {
        let triangle = &self.triangle(triangle);
        let primitive = self.primitive(triangle);
        let normal_matrix = self.posed.primitives[triangle.primitive].normal_matrix();
        let normals = triangle.vertices.map(|vertex| {
            let local = primitive.normals[vertex as usize].as_dvec3();
            (normal_matrix * local).normalize_or_zero()
        });
        let mean: DVec3 = (0..3).map(|k| normals[k] * weights[k]).sum();
        // If the vertex normals cancel, there is nothing to interpolate: the face's own normal replaces them.
        let normal = if mean.length_squared() > 1e-12 { mean.normalize() } else { triangle.normal().normalize() };
        let bulge = |k: usize| (triangle.corners[k] - position).dot(normals[k] - mean).abs();
        (normal, (0..3).map(|k| weights[k].max(0.0) * bulge(k)).sum())
    }
}

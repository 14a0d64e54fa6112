//! What a camera sees: a point of a surface.

use glam::DVec3;
use scene::ViewRay;

use crate::{Bvh, Hit};

/// A point of a surface, seen from somewhere.
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
    /// How far along `normal` its shadow is looked for from `position`, in world units: 0 or more. See
    /// [`Self::shadow_position`].
    pub terminator_offset: f64,
    /// Unit vector towards the viewer.
    pub to_eye: DVec3,
    /// Index of the node in the scene.
    pub node: usize,
    /// Index in [`Bvh::triangles`].
    pub triangle: usize,
    /// Weights of the triangle's corners.
    pub barycentrics: DVec3,
}

impl SeenPoint {
    /// Where light has to arrive in scene space: in front of the triangle by what the smooth surface that the vertex normals
    /// stand for is curved over it, so that facets do not shadow each other where light grazes.
    ///
    /// `P + h n`, `h = sum b_i |(p_i - P) . (n_i - m)|` over the corners `p_i` with their normals `n_i` and the point's
    /// weights `b_i`, `m = sum b_i n_i` and n its direction. After Hanika, "Hacking the Shadow Terminator" (Ray Tracing
    /// Gems II, chapter 4), whose offset this is where the surface bulges: on a ball twice its height over the facet. He
    /// moves nothing where it is hollow, and then a saddle, as at the neck of a vase, keeps its teeth; and he has no m,
    /// which takes out what all normals lean alike, as those of leaves may.
    pub fn shadow_position(&self) -> DVec3 {
        self.position + self.normal * self.terminator_offset
    }

    /// Unit vector to where light comes from that a mirror here would send to the viewer.
    pub fn mirror_direction(&self) -> DVec3 {
        self.normal * (2.0 * self.normal.dot(self.to_eye)) - self.to_eye
    }
}

impl Bvh {
    /// The first surface on a ray of a camera. Back faces are seen where the material is double-sided; holes of an alpha-tested
    /// one are not there. `None` where there is only background.
    pub fn visible_point(&self, ray: &ViewRay) -> Option<SeenPoint> {
        self.visible_point_budgeted(ray, |_| true)
    }

    /// The same by steps that are counted, as of [`Self::first_hit_budgeted`].
    pub fn visible_point_budgeted(&self, ray: &ViewRay, spend: impl Fn(u64) -> bool) -> Option<SeenPoint> {
        let hit = self.first_hit_budgeted(ray.origin, ray.direction, ray.depth_range, spend, |hit| {
            let triangle = &self.triangles[hit.triangle];
            let front = triangle.normal().dot(ray.direction) < 0.0;
            (front || self.material(triangle).double_sided)
                && self.passes_alpha_test(triangle, hit.barycentrics)
        })?;
        Some(self.visible_point_at(ray, &hit))
    }

    fn visible_point_at(&self, ray: &ViewRay, hit: &Hit) -> SeenPoint {
        let triangle = &self.triangles[hit.triangle];
        let face = triangle.normal().normalize();
        let side = if face.dot(ray.direction) < 0.0 { 1.0 } else { -1.0 };
        let position = ray.origin + ray.direction * hit.distance;
        let (normal, terminator_offset) = self.smooth_surface_at(hit.triangle, hit.barycentrics, position);
        SeenPoint {
            position,
            depth: hit.distance,
            geometric_normal: face * side,
            normal: normal * side,
            terminator_offset,
            to_eye: -ray.direction.normalize(),
            node: triangle.node,
            triangle: hit.triangle,
            barycentrics: hit.barycentrics,
        }
    }

    /// The smooth surface that the vertex normals of a triangle stand for, at a position on it with those weights of its corners:
    /// its unit normal on the triangle's front, and [`SeenPoint::terminator_offset`].
    pub fn smooth_surface_at(&self, triangle: usize, weights: DVec3, position: DVec3) -> (DVec3, f64) {
        let triangle = &self.triangles[triangle];
        let primitive = self.primitive(triangle);
        let normal_matrix = self.posed.primitives[triangle.primitive].normal_matrix();
        let normals = triangle.vertices.map(|vertex| {
            let local = primitive.normals[vertex as usize].as_dvec3();
            (normal_matrix * local).normalize_or_zero()
        });
        let mean: DVec3 = (0..3).map(|k| normals[k] * weights[k]).sum();
        // Vertex normals that cancel leave nothing to interpolate: the face's own normal then.
        let normal =
            if mean.length_squared() > 1e-12 { mean.normalize() } else { triangle.normal().normalize() };
        let bulge = |k: usize| (triangle.corners[k] - position).dot(normals[k] - mean).abs();
        (normal, (0..3).map(|k| weights[k].max(0.0) * bulge(k)).sum())
    }
}

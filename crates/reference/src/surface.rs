//! What a camera sees: a point of a surface and its material there.

use glam::{DVec2, DVec3, DVec4};
use raycast::{Hit, Triangle};
use scene::{Material, Primitive, View};

use crate::Reference;
use crate::camera::ViewRay;
use crate::texture::Footprint;

/// A point of a surface, seen from somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
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
    /// Linear, 0 to 1.
    pub base_color: DVec3,
    /// 0 to 1.
    pub metallic: f64,
    /// Perceptual, 0 to 1: the GGX alpha is its square.
    pub roughness: f64,
    /// Index of the node in the scene.
    pub node: usize,
    /// Index in [`raycast::Bvh::triangles`].
    pub triangle: usize,
}

impl Surface {
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
}

impl Reference {
    /// What `view`'s camera sees through a point of the picture, in pixels from its top left corner: (0.5,
    /// 0.5) is the centre of the first pixel. `None` where there is only background.
    ///
    /// Back faces are seen where the material is double-sided; holes of an alpha-tested one are not there.
    pub fn surface(&self, view: &View, pixel: DVec2) -> Option<Surface> {
        let ray = self.ray(view, pixel);
        let (origin, direction) = (ray.origin, ray.direction);
        let hit = self.bvh.first_hit(origin, direction, ray.range, |hit| {
            let triangle = &self.bvh.triangles[hit.triangle];
            let front = triangle.normal().dot(direction) < 0.0;
            (front || self.material(triangle).double_sided) && self.is_solid(triangle, hit.weights)
        })?;
        Some(self.surface_at(view, pixel, &ray, &hit))
    }

    fn ray(&self, view: &View, pixel: DVec2) -> ViewRay {
        ViewRay::new(view, pixel, self.bvh.posed.origin_in_world)
    }

    fn surface_at(&self, view: &View, pixel: DVec2, ray: &ViewRay, hit: &Hit) -> Surface {
        let triangle = &self.bvh.triangles[hit.triangle];
        let primitive = self.primitive(triangle);
        let face = triangle.normal().normalize();
        let side = if face.dot(ray.direction) < 0.0 { 1.0 } else { -1.0 };
        let (normal_matrix, vertices) =
            (self.bvh.posed.primitives[triangle.primitive].normal_matrix(), triangle.vertices);
        let normals = vertices.map(|vertex| {
            let local = primitive.normals[vertex as usize].as_dvec3();
            (normal_matrix * local).normalize_or_zero()
        });
        let mean: DVec3 = (0..3).map(|k| normals[k] * hit.weights[k]).sum();
        // Vertex normals that cancel leave nothing to interpolate: the face's own normal then.
        let normal = if mean.length_squared() > 1e-12 { mean.normalize() } else { face };

        let material = self.material(triangle);
        let footprint = self.footprint(view, pixel, triangle, hit.weights);
        let base = self.base_color(triangle, material, &footprint, hit.weights);
        let texel = material
            .metallic_roughness_texture
            .map_or(DVec4::ONE, |texture| self.textures.linear(texture, &footprint));
        let position = ray.origin + ray.direction * hit.distance;
        let bulge = |k: usize| (triangle.corners[k] - position).dot(normals[k] - mean).abs();
        Surface {
            position,
            depth: hit.distance,
            geometric_normal: face * side,
            normal: normal * side,
            terminator_offset: (0..3).map(|k| hit.weights[k].max(0.0) * bulge(k)).sum(),
            to_eye: -ray.direction.normalize(),
            base_color: base.truncate().clamp(DVec3::ZERO, DVec3::ONE),
            metallic: (f64::from(material.metallic) * texel.z).clamp(0.0, 1.0),
            roughness: (f64::from(material.roughness) * texel.y).clamp(0.0, 1.0),
            node: triangle.node,
            triangle: hit.triangle,
        }
    }

    fn primitive(&self, triangle: &Triangle) -> &Primitive {
        let posed = &self.bvh.posed;
        posed.geometry(&posed.primitives[triangle.primitive])
    }

    pub(crate) fn material(&self, triangle: &Triangle) -> &Material {
        &self.bvh.posed.scene.materials[self.primitive(triangle).material]
    }

    /// Whether an alpha-tested material is there at a point of one of its triangles; in full detail, since
    /// light that passes has no pixels.
    pub(crate) fn is_solid(&self, triangle: &Triangle, weights: DVec3) -> bool {
        let material = self.material(triangle);
        material.alpha_cutoff.is_none_or(|cutoff| {
            let footprint = Footprint::point(self.uv(triangle, weights));
            self.base_color(triangle, material, &footprint, weights).w >= f64::from(cutoff)
        })
    }

    fn base_color(
        &self,
        triangle: &Triangle,
        material: &Material,
        footprint: &Footprint,
        weights: DVec3,
    ) -> DVec4 {
        let colors = &self.primitive(triangle).colors;
        let color: DVec4 = if colors.is_empty() {
            DVec4::ONE
        } else {
            (0..3).map(|k| colors[triangle.vertices[k] as usize].as_dvec4() * weights[k]).sum()
        };
        let texel =
            material.base_color_texture.map_or(DVec4::ONE, |texture| self.textures.srgb(texture, footprint));
        material.base_color.as_dvec4() * color * texel
    }

    fn uv(&self, triangle: &Triangle, weights: DVec3) -> DVec2 {
        let uvs = &self.primitive(triangle).uvs;
        if uvs.is_empty() {
            return DVec2::ZERO;
        }
        (0..3).map(|k| uvs[triangle.vertices[k] as usize].as_dvec2() * weights[k]).sum()
    }

    /// What a pixel covers of a texture: how uv changes over the triangle's plane to the next pixel in x and
    /// y.
    fn footprint(&self, view: &View, pixel: DVec2, triangle: &Triangle, weights: DVec3) -> Footprint {
        let uv = self.uv(triangle, weights);
        let step = |by: DVec2| {
            let ray = self.ray(view, pixel + by);
            let [a, b, c] = triangle.corners;
            let normal = triangle.normal();
            let distance = normal.dot(a - ray.origin) / normal.dot(ray.direction);
            let at = ray.origin + ray.direction * distance - a;
            let area2 = normal.length_squared();
            let (beta, gamma) = (at.cross(c - a).dot(normal) / area2, (b - a).cross(at).dot(normal) / area2);
            self.uv(triangle, DVec3::new(1.0 - beta - gamma, beta, gamma)) - uv
        };
        Footprint { uv, dx: step(DVec2::X), dy: step(DVec2::Y) }
    }
}

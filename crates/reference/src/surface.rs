//! Surface at a point of a picture, with its material.

use std::ops::Deref;

use glam::{DVec2, DVec3, DVec4};
use raycast::{SeenPoint, Triangle};
use scene::{Material, View, ViewRay};

use crate::Reference;
use crate::texture::Footprint;

/// Visible point of a surface, with its material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadedPoint {
    pub seen: SeenPoint,
    /// Linear RGB, 0 to 1.
    pub base_color: DVec3,
    pub metallic: f64,
    /// Perceptual roughness, 0 to 1. The GGX alpha is its square.
    pub roughness: f64,
}

impl Deref for ShadedPoint {
    type Target = SeenPoint;

    fn deref(&self) -> &SeenPoint {
        &self.seen
    }
}

impl Reference {
    /// Returns the surface that `view`'s camera sees at a point of the picture, in pixels from the top left
    /// corner: (0.5, 0.5) is the centre of the first pixel. Returns `None` if there is only background.
    ///
    /// Back faces are visible if the material is double-sided. Holes of an alpha-tested material are not.
    pub fn surface(&self, view: &View, pixel: DVec2) -> Option<ShadedPoint> {
        let seen = self.bvh.visible_point(&self.ray(view, pixel))?;
        let triangle = &self.bvh.triangle(seen.triangle);
        let material = self.bvh.material(triangle);
        let footprint = self.footprint(view, pixel, triangle, seen.barycentrics);
        let base = self.base_color(triangle, material, &footprint, seen.barycentrics);
        let texel =
            material.metallic_roughness_texture.map_or(DVec4::ONE, |texture| self.textures.linear(texture, &footprint));
        Some(ShadedPoint {
            seen,
            base_color: base.truncate().clamp(DVec3::ZERO, DVec3::ONE),
            metallic: (f64::from(material.metallic) * texel.z).clamp(0.0, 1.0),
            roughness: (f64::from(material.roughness) * texel.y).clamp(0.0, 1.0),
        })
    }

    fn ray(&self, view: &View, pixel: DVec2) -> ViewRay {
        ViewRay::new(&view.camera, [view.width, view.height], pixel, self.bvh.posed.origin_in_world)
    }

    fn base_color(&self, triangle: &Triangle, material: &Material, footprint: &Footprint, weights: DVec3) -> DVec4 {
        let colors = &self.bvh.primitive(triangle).colors;
        let color: DVec4 = if colors.is_empty() {
            DVec4::ONE
        } else {
            (0..3).map(|k| colors[triangle.vertices[k] as usize].as_dvec4() * weights[k]).sum()
        };
        let texel = material.base_color_texture.map_or(DVec4::ONE, |texture| self.textures.srgb(texture, footprint));
        material.base_color.as_dvec4() * color * texel
    }

    /// Computes the footprint of a pixel in a texture: the change of uv over the triangle's plane to the next
    /// pixel in x and in y.
    fn footprint(&self, view: &View, pixel: DVec2, triangle: &Triangle, weights: DVec3) -> Footprint {
        let uv = self.bvh.uv(triangle, weights);
        let step = |by: DVec2| {
            let ray = self.ray(view, pixel + by);
            let normal = triangle.normal();
            let distance = normal.dot(triangle.corners[0] - ray.origin) / normal.dot(ray.direction);
            self.bvh.uv(triangle, triangle.plane_barycentrics(ray.origin + ray.direction * distance)) - uv
        };
        Footprint { uv, dx: step(DVec2::X), dy: step(DVec2::Y) }
    }
}

//! Alpha test of surfaces.

use glam::{DVec2, DVec3};
use scene::{Image, Material, Primitive, TextureRef};

use crate::{Bvh, Triangle};

impl Bvh {
    /// Returns the geometry of a triangle.
    pub fn primitive(&self, triangle: &Triangle) -> &Primitive {
        self.posed.geometry(&self.posed.primitives[triangle.primitive])
    }

    pub fn material(&self, triangle: &Triangle) -> &Material {
        &self.posed.scene.materials[self.primitive(triangle).material]
    }

    /// Returns the texture coordinates at a point of a triangle, by its barycentric weights.
    pub fn uv(&self, triangle: &Triangle, weights: DVec3) -> DVec2 {
        let uvs = &self.primitive(triangle).uvs;
        if uvs.is_empty() {
            return DVec2::ZERO;
        }
        (0..3).map(|k| uvs[triangle.vertices[k] as usize].as_dvec2() * weights[k]).sum()
    }

    /// Returns true if a point of a triangle passes its material's alpha test. The texture is read in full detail,
    /// since a light path has no pixels.
    pub fn passes_alpha_test(&self, triangle: &Triangle, weights: DVec3) -> bool {
        let material = self.material(triangle);
        let Some(cutoff) = material.alpha_cutoff else { return true };
        let colors = &self.primitive(triangle).colors;
        let vertices = if colors.is_empty() {
            1.0
        } else {
            (0..3).map(|k| f64::from(colors[triangle.vertices[k] as usize].w) * weights[k]).sum()
        };
        let texel = material
            .base_color_texture
            .map_or(1.0, |texture| alpha(&self.posed.scene.images[texture.image], texture, self.uv(triangle, weights)));
        f64::from(material.base_color.w) * vertices * texel >= f64::from(cutoff)
    }
}

/// Returns the alpha of an image at full size.
fn alpha(image: &Image, texture: TextureRef, uv: DVec2) -> f64 {
    let sampler = texture.sampler;
    let texel = |x: f64, y: f64| {
        let (column, row) =
            (sampler.wrap_u.texel(x, image.width as usize), sampler.wrap_v.texel(y, image.height as usize));
        f64::from(image.rgba8[4 * (row * image.width as usize + column) + 3]) / 255.0
    };
    let at = uv * DVec2::new(f64::from(image.width), f64::from(image.height));
    if sampler.nearest {
        return texel(at.x.floor(), at.y.floor());
    }
    let at = at - 0.5;
    let (first, share) = (at.floor(), at - at.floor());
    let row = |y: f64| {
        let (left, right) = (texel(first.x, y), texel(first.x + 1.0, y));
        left + (right - left) * share.x
    };
    let (above, below) = (row(first.y), row(first.y + 1.0));
    above + (below - above) * share.y
}

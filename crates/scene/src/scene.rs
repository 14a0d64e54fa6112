//! What importers make: geometry and materials.

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use thiserror::Error;

/// Everything that is drawn and everything that lights it. World space is right-handed, +Y up, metres by habit.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The node hierarchy. Parents come before their children.
    pub nodes: Vec<Node>,
    /// Meshes that nodes refer to; one mesh may stand in many places.
    pub meshes: Vec<Mesh>,
    /// Materials that primitives refer to.
    pub materials: Vec<Material>,
    /// Decoded pictures that materials refer to.
    pub images: Vec<Image>,
    /// Light from everywhere, so that what no light reaches can be read.
    pub fill: Fill,
}

/// A place in the hierarchy.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name for people; not unique.
    pub name: String,
    /// Index of the parent in [`Scene::nodes`], less than this node's own.
    pub parent: Option<usize>,
    /// Placement in the parent's space; finite, may be singular.
    pub parent_from_local: DAffine3,
    /// Index in [`Scene::meshes`].
    pub mesh: Option<usize>,
}

/// Primitives that move together.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Name for people.
    pub name: String,
    /// One a material.
    pub primitives: Vec<Primitive>,
}

/// A triangle list with one material, in mesh-local space.
///
/// `normals` has one unit vector a vertex; `uvs` and `colors` are empty or have one entry a vertex.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// Finite positions.
    pub positions: Vec<Vec3>,
    /// Unit shading normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, glTF's convention: origin at the top left.
    pub uvs: Vec<Vec2>,
    /// Linear RGBA that multiplies the base colour.
    pub colors: Vec<Vec4>,
    /// Three a triangle, each less than the vertex count.
    pub indices: Vec<u32>,
    /// Index in [`Scene::materials`].
    pub material: usize,
}

/// glTF's metallic-roughness material.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name for people.
    pub name: String,
    /// Linear RGBA.
    pub base_color: Vec4,
    /// 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1; the GGX alpha is its square.
    pub roughness: f32,
    /// sRGB picture that multiplies the base colour.
    pub base_color_texture: Option<TextureRef>,
    /// Linear picture: roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Fragments with less alpha are not drawn; `None` draws all.
    pub alpha_cutoff: Option<f32>,
    /// Draw back faces too.
    pub double_sided: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            metallic: 0.0,
            roughness: 1.0,
            base_color_texture: None,
            metallic_roughness_texture: None,
            alpha_cutoff: None,
            double_sided: false,
        }
    }
}

/// A picture and how it is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureRef {
    /// Index in [`Scene::images`].
    pub image: usize,
    /// How it is read.
    pub sampler: Sampler,
}

/// glTF's sampler: wrapping and whether magnified texels are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sampler {
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// Nearest texel instead of a blend.
    pub nearest: bool,
}

/// What a texture does outside 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// Starts again.
    #[default]
    Repeat,
    /// Starts again, mirrored.
    MirroredRepeat,
    /// Goes on with its edge.
    ClampToEdge,
}

impl Wrap {
    /// The texel of `size` that index `x`, a whole number, stands for.
    pub fn texel(self, x: f64, size: usize) -> usize {
        let n = size as f64;
        let inside = match self {
            Self::Repeat => x.rem_euclid(n),
            Self::MirroredRepeat => {
                let twice = x.rem_euclid(2.0 * n);
                twice.min(2.0 * n - 1.0 - twice)
            }
            Self::ClampToEdge => x.clamp(0.0, n - 1.0),
        };
        (inside as usize).min(size - 1)
    }
}

/// Eight bits a channel RGBA, rows from the top, `width * height * 4` bytes, as stored (sRGB for colours).
#[derive(Clone)]
pub struct Image {
    /// Pixels, at least 1.
    pub width: u32,
    /// Pixels, at least 1.
    pub height: u32,
    /// The bytes.
    pub rgba8: Vec<u8>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({} x {})", self.width, self.height)
    }
}

/// Hemisphere fill: irradiance over pi from above and below, blended by the normal's height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Radiance of the upper hemisphere, linear RGB.
    pub sky: DVec3,
    /// Radiance of the lower hemisphere, linear RGB.
    pub ground: DVec3,
}

impl Default for Fill {
    fn default() -> Self {
        Self { sky: DVec3::splat(0.10), ground: DVec3::splat(0.05) }
    }
}

/// A broken promise in a [`Scene`].
#[derive(Debug, Error, PartialEq, Eq)]
#[error("{what} {index} is not sound: {why}")]
pub struct SceneError {
    /// Which kind of thing.
    pub what: &'static str,
    /// Its index in the scene.
    pub index: usize,
    /// Which promise.
    pub why: &'static str,
}

impl Scene {
    /// Verifies every promise stated on the fields: indices in range, parents first, lengths equal, numbers
    /// finite.
    pub fn check(&self) -> Result<(), SceneError> {
        let fail = |what, index, why| Err(SceneError { what, index, why });
        for (i, node) in self.nodes.iter().enumerate() {
            if node.parent.is_some_and(|p| p >= i) {
                return fail("node", i, "its parent does not come before it");
            }
            if node.mesh.is_some_and(|m| m >= self.meshes.len()) {
                return fail("node", i, "its mesh does not exist");
            }
            if !node.parent_from_local.is_finite() {
                return fail("node", i, "its transform is not finite");
            }
        }
        for (i, mesh) in self.meshes.iter().enumerate() {
            for p in &mesh.primitives {
                let n = p.positions.len();
                let optional = |len: usize| len == 0 || len == n;
                if p.normals.len() != n || !optional(p.uvs.len()) || !optional(p.colors.len()) {
                    return fail("mesh", i, "its attributes differ in length");
                }
                if p.indices.len() % 3 != 0 || p.indices.iter().any(|&k| k as usize >= n) {
                    return fail("mesh", i, "its indices do not form triangles of its vertices");
                }
                if p.material >= self.materials.len() {
                    return fail("mesh", i, "its material does not exist");
                }
                let finite = p.positions.iter().chain(&p.normals).all(|v| v.is_finite())
                    && p.uvs.iter().all(|v| v.is_finite())
                    && p.colors.iter().all(|v| v.is_finite());
                if !finite {
                    return fail("mesh", i, "it has positions, normals, uvs or colours that are not finite");
                }
            }
        }
        for (i, m) in self.materials.iter().enumerate() {
            let textures = [m.base_color_texture, m.metallic_roughness_texture];
            if textures.iter().flatten().any(|t| t.image >= self.images.len()) {
                return fail("material", i, "its picture does not exist");
            }
        }
        for (i, image) in self.images.iter().enumerate() {
            if image.width == 0 || image.rgba8.len() != image.width as usize * image.height as usize * 4 {
                return fail("image", i, "its bytes do not fill its width and height");
            }
        }
        Ok(())
    }
}

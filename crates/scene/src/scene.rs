//! Geometry and materials, as importers fill them in.

use glam::{DAffine3, DVec3, Vec2, Vec3, Vec4};
use thiserror::Error;

/// Geometry, materials and ambient fill of a scene. World space is right-handed with +Y up, in metres by convention.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Node hierarchy. Parents come before their children.
    pub nodes: Vec<Node>,
    /// Meshes, referred to by nodes. Several nodes may refer to one mesh.
    pub meshes: Vec<Mesh>,
    /// Materials, referred to by primitives.
    pub materials: Vec<Material>,
    /// Decoded pictures, referred to by materials.
    pub images: Vec<Image>,
    /// Ambient light from all directions. It keeps areas readable that no light reaches.
    pub fill: Fill,
}

/// Node of the hierarchy.
#[derive(Clone, Debug)]
pub struct Node {
    /// Name for people; not unique.
    pub name: String,
    /// Index of the parent in [`Scene::nodes`], less than this node's own.
    pub parent: Option<usize>,
    /// Transform into the parent's space; finite, may be singular.
    pub parent_from_local: DAffine3,
    /// Index in [`Scene::meshes`].
    pub mesh: Option<usize>,
}

/// Primitives that share a transform.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    pub name: String,
    /// One for each material.
    pub primitives: Vec<Primitive>,
}

/// A triangle list with one material, in mesh-local space.
///
/// `normals` has one unit vector a vertex; `uvs` and `colors` are empty or have one entry a vertex.
#[derive(Clone, Debug, Default)]
pub struct Primitive {
    /// Positions of the vertices; finite numbers.
    pub positions: Vec<Vec3>,
    /// Normals of the vertices; unit vectors.
    pub normals: Vec<Vec3>,
    /// Texture coordinates, glTF's convention: origin at the top left.
    pub uvs: Vec<Vec2>,
    /// Colours of the vertices: linear RGBA that multiplies the base colour.
    pub colors: Vec<Vec4>,
    /// Indices of vertices, three for each triangle; each is less than the number of vertices.
    pub indices: Vec<u32>,
    /// Index in [`Scene::materials`].
    pub material: usize,
}

/// glTF's metallic-roughness material.
#[derive(Clone, Debug)]
pub struct Material {
    pub name: String,
    /// Linear RGBA base colour.
    pub base_color: Vec4,
    /// Metallic factor, from 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1. The GGX alpha is its square.
    pub roughness: f32,
    /// sRGB picture that multiplies the base colour.
    pub base_color_texture: Option<TextureRef>,
    /// Linear picture: roughness in green, metallic in blue.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Minimum alpha of a fragment that is drawn; `None` draws all.
    pub alpha_cutoff: Option<f32>,
    /// True if back faces are drawn too.
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

/// Reference to a picture, with its sampler.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TextureRef {
    /// Index in [`Scene::images`].
    pub image: usize,
    pub sampler: Sampler,
}

/// Sampler, as in glTF: wrap modes and the magnification filter.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sampler {
    pub wrap_u: Wrap,
    pub wrap_v: Wrap,
    /// True for the nearest texel, false for a blend of texels.
    pub nearest: bool,
}

/// Wrap mode of a texture outside 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Wrap {
    #[default]
    Repeat,
    MirroredRepeat,
    ClampToEdge,
}

impl Wrap {
    /// Maps the texel index `x`, a whole number, into a texture of `size` texels.
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

/// RGBA picture of 8 bits a channel, rows from the top, as stored (sRGB for colours).
#[derive(Clone)]
pub struct Image {
    /// In pixels, at least 1.
    pub width: u32,
    /// In pixels, at least 1.
    pub height: u32,
    /// Pixels, `width * height * 4` bytes.
    pub rgba8: Vec<u8>,
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({} x {})", self.width, self.height)
    }
}

/// Hemisphere fill: irradiance over pi from above and below, blended by the height of the normal.
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

/// Error of a [`Scene`] that violates one of the conditions on its fields.
#[derive(Debug, Error, PartialEq, Eq)]
#[error("{what} {index} is not sound: {why}")]
pub struct SceneError {
    /// Kind of the broken item ("node", "mesh").
    pub what: &'static str,
    pub index: usize,
    /// Condition that is violated, as a clause.
    pub why: &'static str,
}

impl Scene {
    /// Checks all conditions that the fields' documentation states: indices in range, parents before children, equal
    /// lengths, finite numbers.
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

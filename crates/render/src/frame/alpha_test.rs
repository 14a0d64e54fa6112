//! All alpha tests of a scene in one table, for passes that draw triangles of all materials in one call.

use std::collections::HashMap;
use std::ops::Range;

use relight::{AlphaTest, TexelWrap};
use scene::{Scene, TextureRef, Wrap};

use super::geometry::MaterialRange;

/// Alpha tests, with the texels that they read.
#[derive(Debug, Default)]
pub(crate) struct AlphaTestList {
    /// Tests, one for each draw with an alpha test, in the order of their triangles.
    pub tests: Vec<AlphaTest>,
    /// Alpha of all tested textures, one after another, eight bits per texel.
    pub texels: Vec<u8>,
}

/// Triangles with an alpha test and one material.
#[derive(Clone, Debug)]
pub(crate) struct AlphaTestedDraw {
    /// Index of the scene's draw that has the material.
    pub draw: usize,
    pub indices: Range<u32>,
}

/// Position of a texture's alpha within the texels of all tests.
#[derive(Clone, Copy, Debug)]
struct AlphaPicture {
    offset: u32,
    width: u32,
    height: u32,
}

impl AlphaTestList {
    /// Makes the tests of `draws`, all of which have one; `None` if there are none.
    pub fn new(scene: &Scene, draws: &[MaterialRange]) -> Option<Self> {
        let first = draws.first()?;
        let (mut list, mut pictures) = (Self::default(), HashMap::new());
        for draw in draws {
            let material = &scene.materials[draw.material];
            let texture = material.base_color_texture;
            let picture = *pictures
                .entry(texture.map(|texture| texture.image))
                .or_insert_with(|| list.add_picture(scene, texture));
            let AlphaPicture { offset, width, height } = picture;
            let sampler = texture.map(|texture| texture.sampler).unwrap_or_default();
            list.tests.push(AlphaTest {
                first_triangle: (draw.indices.start - first.indices.start) / 3,
                first_index: draw.indices.start,
                cutoff: material.alpha_cutoff.unwrap_or(0.0),
                factor: material.base_color.w,
                offset,
                width,
                height,
                wrap_u: texel_wrap(sampler.wrap_u),
                wrap_v: texel_wrap(sampler.wrap_v),
                nearest: sampler.nearest,
            });
        }
        Some(list)
    }

    /// Adds the alpha of `texture`, or of a white texel.
    fn add_picture(&mut self, scene: &Scene, texture: Option<TextureRef>) -> AlphaPicture {
        let offset = self.texels.len() as u32;
        let Some(TextureRef { image, .. }) = texture else {
            self.texels.push(u8::MAX);
            return AlphaPicture { offset, width: 1, height: 1 };
        };
        let image = &scene.images[image];
        self.texels.extend(image.rgba8.iter().skip(3).step_by(4));
        AlphaPicture { offset, width: image.width, height: image.height }
    }
}

pub(crate) fn texel_wrap(wrap: Wrap) -> TexelWrap {
    match wrap {
        Wrap::Repeat => TexelWrap::Repeat,
        Wrap::MirroredRepeat => TexelWrap::MirroredRepeat,
        Wrap::ClampToEdge => TexelWrap::ClampToEdge,
    }
}

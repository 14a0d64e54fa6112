//! The alpha tests of a scene in one table, for passes that draw triangles of all materials at once.

use scene::{Material, Sampler, Wrap};
use wgpu::{Buffer, BufferUsages};

use crate::geometry::{Draw, upload};
use crate::{Gpu, RenderError, gpu_structs};

const TESTS: &str = "the scene's alpha tests in bytes";
const TEXELS: &str = "the alpha of the scene's textures in bytes";

/// See `alpha_test.wgsl`.
#[derive(Debug)]
pub(crate) struct AlphaTests {
    /// One a draw with an alpha test, by their triangles.
    pub list: Vec<gpu_structs::AlphaTest>,
    /// The same on the device.
    pub tests: Buffer,
    /// All their pictures.
    pub texels: Buffer,
}

/// Where a picture's alpha lies among the texels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlphaPicture {
    pub offset: u32,
    pub width: u32,
    pub height: u32,
    pub levels: u32,
}

impl AlphaTests {
    /// `texels` have eight bits each.
    pub fn new(
        gpu: &Gpu,
        list: Vec<gpu_structs::AlphaTest>,
        mut texels: Vec<u8>,
    ) -> Result<Self, RenderError> {
        texels.resize(texels.len().next_multiple_of(4), 0);
        let texels = upload(gpu, TEXELS, &texels, BufferUsages::STORAGE)?;
        Ok(Self { tests: upload(gpu, TESTS, &list, BufferUsages::STORAGE)?, list, texels })
    }

    /// Other tests by the same pictures.
    pub fn with_tests(&self, gpu: &Gpu, list: Vec<gpu_structs::AlphaTest>) -> Result<Self, RenderError> {
        let tests = upload(gpu, TESTS, &list, BufferUsages::STORAGE)?;
        Ok(Self { list, tests, texels: self.texels.clone() })
    }

    /// One test that no triangle has: a binding may not be empty.
    pub fn none(gpu: &Gpu) -> Result<Self, RenderError> {
        Self::new(
            gpu,
            vec![gpu_structs::AlphaTest { first_index: u32::MAX, ..gpu_structs::AlphaTest::default() }],
            vec![0],
        )
    }

    pub fn bytes(&self) -> u64 {
        self.tests.size() + self.texels.size()
    }
}

/// The test of `draw`, where triangles with a test begin with the index `first_masked`.
pub(crate) fn alpha_test(
    draw: &Draw,
    first_masked: u32,
    material: &Material,
    picture: AlphaPicture,
) -> gpu_structs::AlphaTest {
    let wrap = |wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::MirroredRepeat => 1,
        Wrap::ClampToEdge => 2,
    };
    let Sampler { wrap_u, wrap_v, nearest } =
        material.base_color_texture.map(|texture| texture.sampler).unwrap_or_default();
    let AlphaPicture { offset, width, height, levels } = picture;
    gpu_structs::AlphaTest {
        first_triangle: (draw.indices.start - first_masked) / 3,
        first_index: draw.indices.start,
        cutoff: material.alpha_cutoff.unwrap_or(0.0),
        factor: material.base_color.w,
        offset,
        width,
        height,
        levels,
        wrap_u: wrap(wrap_u),
        wrap_v: wrap(wrap_v),
        nearest: u32::from(nearest),
    }
}

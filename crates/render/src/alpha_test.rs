//! All alpha tests of a scene in one table, for passes that draw triangles of all materials in one call.

use std::sync::Arc;

use scene::{Material, Wrap};
use wgpu::{Buffer, BufferUsages};

use crate::geometry::{MaterialRange, upload};
use crate::{Gpu, RenderError, gpu_structs};

const TESTS: &str = "the scene's alpha tests in bytes";
const TEXELS: &str = "the alpha of the scene's textures in bytes";

/// Alpha tests of a scene on the GPU, with the texels that they read. `alpha_test.wgsl` has the layout.
#[derive(Debug)]
pub(crate) struct GpuAlphaTests {
    /// Tests, one for each draw with an alpha test, in the order of their triangles.
    pub list: Vec<gpu_structs::AlphaTest>,
    pub tests: Buffer,
    /// Alpha of all tested textures, one after another.
    pub texels: Buffer,
    /// Same tests in CPU memory, for the native backend.
    host_tests: Vec<relight::AlphaTest>,
    pub host_texels: Option<Arc<[u8]>>,
}

/// Position of a texture's alpha within the texels of all tests.
#[derive(Clone, Copy, Debug)]
pub(crate) struct AlphaPicture {
    pub offset: u32,
    pub width: u32,
    pub height: u32,
}

impl GpuAlphaTests {
    /// Uploads the tests and their texels. `texels` has eight bits per texel.
    pub fn new(gpu: &Gpu, list: Vec<gpu_structs::AlphaTest>, mut texels: Vec<u8>) -> Result<Self, RenderError> {
        texels.resize(texels.len().next_multiple_of(4), 0);
        Ok(Self {
            tests: upload(gpu, TESTS, &list, BufferUsages::STORAGE)?,
            host_tests: list.iter().map(host_test).collect(),
            list,
            texels: upload(gpu, TEXELS, &texels, BufferUsages::STORAGE)?,
            host_texels: gpu.if_native(|| texels.into()),
        })
    }

    /// Makes a table of other tests over the same texels.
    pub fn with_tests(&self, gpu: &Gpu, list: Vec<gpu_structs::AlphaTest>) -> Result<Self, RenderError> {
        let tests = upload(gpu, TESTS, &list, BufferUsages::STORAGE)?;
        let host_tests = list.iter().map(host_test).collect();
        Ok(Self { list, tests, texels: self.texels.clone(), host_tests, host_texels: self.host_texels.clone() })
    }

    /// Makes a table with one test that applies to no triangle, because a binding must not be empty.
    pub fn none(gpu: &Gpu) -> Result<Self, RenderError> {
        Self::new(
            gpu,
            vec![gpu_structs::AlphaTest { first_index: u32::MAX, ..gpu_structs::AlphaTest::default() }],
            vec![0],
        )
    }

    /// Returns the tests for the native backend. Panics on the wgpu backend.
    pub fn host(&self) -> relight::AlphaTests<'_> {
        relight::AlphaTests {
            tests: &self.host_tests,
            texels: self.host_texels.as_deref().expect("they are there where the processor draws"),
        }
    }

    /// Returns the bytes of the buffers and of texels in CPU memory.
    pub fn bytes(&self) -> u64 {
        let host = self.host_texels.as_ref().map_or(0, |texels| texels.len() as u64);
        self.tests.size() + self.texels.size() + host
    }
}

/// Converts a test to the native backend's type.
fn host_test(test: &gpu_structs::AlphaTest) -> relight::AlphaTest {
    let wrap = |wrap| match wrap {
        0 => relight::TexelWrap::Repeat,
        1 => relight::TexelWrap::MirroredRepeat,
        _ => relight::TexelWrap::ClampToEdge,
    };
    let gpu_structs::AlphaTest { first_triangle, first_index, cutoff, factor, .. } = *test;
    let gpu_structs::AlphaTest { offset, width, height, .. } = *test;
    let (wrap_u, wrap_v, nearest) = (wrap(test.wrap_u), wrap(test.wrap_v), test.nearest != 0);
    relight::AlphaTest { first_triangle, first_index, cutoff, factor, offset, width, height, wrap_u, wrap_v, nearest }
}

/// Makes the alpha test of `draw`. `first_masked` is the index at which alpha-tested triangles begin.
pub(crate) fn alpha_test(
    draw: &MaterialRange,
    first_masked: u32,
    material: &Material,
    picture: AlphaPicture,
) -> gpu_structs::AlphaTest {
    let sampler = material.base_color_texture.map(|texture| texture.sampler).unwrap_or_default();
    let wrap = |wrap| match wrap {
        Wrap::Repeat => 0,
        Wrap::MirroredRepeat => 1,
        Wrap::ClampToEdge => 2,
    };
    let AlphaPicture { offset, width, height } = picture;
    gpu_structs::AlphaTest {
        first_triangle: (draw.indices.start - first_masked) / 3,
        first_index: draw.indices.start,
        cutoff: material.alpha_cutoff.unwrap_or(0.0),
        factor: material.base_color.w,
        offset,
        width,
        height,
        wrap_u: wrap(sampler.wrap_u),
        wrap_v: wrap(sampler.wrap_v),
        nearest: u32::from(sampler.nearest),
    }
}

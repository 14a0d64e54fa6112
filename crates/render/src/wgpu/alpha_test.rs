//! Alpha tests on the GPU.

use relight::{AlphaTest, TexelWrap};
use wgpu::{Buffer, BufferUsages};

use super::gpu_structs;
use crate::frame::AlphaTestList;
use crate::{Gpu, RenderError};

const TESTS: &str = "the scene's alpha tests in bytes";
const TEXELS: &str = "the alpha of the scene's textures in bytes";

/// Alpha tests of a scene on the GPU, with the texels that they read. `alpha_test.wgsl` has the layout.
#[derive(Debug)]
pub(crate) struct GpuAlphaTests {
    pub tests: Buffer,
    /// Alpha of all tested textures, one after another.
    pub texels: Buffer,
}

impl GpuAlphaTests {
    pub fn new(gpu: &Gpu, list: AlphaTestList) -> Result<Self, RenderError> {
        let AlphaTestList { tests, mut texels } = list;
        texels.resize(texels.len().next_multiple_of(4), 0);
        let texels = gpu.upload(TEXELS, &texels, BufferUsages::STORAGE)?;
        Ok(Self { tests: upload_tests(gpu, &tests)?, texels })
    }

    /// Makes a table of other tests over the same texels.
    pub fn with_tests(&self, gpu: &Gpu, tests: &[AlphaTest]) -> Result<Self, RenderError> {
        Ok(Self { tests: upload_tests(gpu, tests)?, texels: self.texels.clone() })
    }

    /// Makes a table with one test that applies to no triangle, because a binding must not be empty.
    pub fn none(gpu: &Gpu) -> Result<Self, RenderError> {
        let test = gpu_structs::AlphaTest { first_index: u32::MAX, ..gpu_structs::AlphaTest::default() };
        Ok(Self {
            tests: gpu.upload(TESTS, &[test], BufferUsages::STORAGE)?,
            texels: gpu.upload(TEXELS, &[0_u32], BufferUsages::STORAGE)?,
        })
    }

    /// Returns the bytes of the buffers.
    pub fn bytes(&self) -> u64 {
        self.tests.size() + self.texels.size()
    }
}

fn upload_tests(gpu: &Gpu, tests: &[AlphaTest]) -> Result<Buffer, RenderError> {
    let tests: Vec<_> = tests.iter().map(gpu_test).collect();
    gpu.upload(TESTS, &tests, BufferUsages::STORAGE)
}

fn gpu_test(test: &AlphaTest) -> gpu_structs::AlphaTest {
    let wrap = |wrap| match wrap {
        TexelWrap::Repeat => 0,
        TexelWrap::MirroredRepeat => 1,
        TexelWrap::ClampToEdge => 2,
    };
    let AlphaTest { first_triangle, first_index, cutoff, factor, offset, width, height, .. } = *test;
    let (wrap_u, wrap_v, nearest) = (wrap(test.wrap_u), wrap(test.wrap_v), u32::from(test.nearest));
    gpu_structs::AlphaTest {
        first_triangle,
        first_index,
        cutoff,
        factor,
        offset,
        width,
        height,
        wrap_u,
        wrap_v,
        nearest,
    }
}

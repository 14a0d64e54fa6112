//! Materials on the GPU: a bind group a draw.

use std::collections::HashMap;
use std::ops::Range;

use scene::{Material, Sampler, Scene, TextureRef, Wrap};
use wgpu::util::{BufferInitDescriptor, DeviceExt, TextureDataOrder};
use wgpu::{
    BindGroup, BindGroupLayout, BindingResource, BindingType, BufferUsages, TextureFormat, TextureView,
};

use crate::alpha_test::{AlphaPicture, AlphaTests, alpha_test};
use crate::geometry::Draw;
use crate::mipmap::{Encoding, MipChain, mip_chain};
use crate::pipeline::{COLOR_TEXTURE, FILTERING, UNIFORM};
use crate::{Gpu, RenderError, gpu_structs};

/// Group 1 of the passes that draw triangles; see `material.wgsl`.
pub(crate) const BINDINGS: [BindingType; 5] = [UNIFORM, COLOR_TEXTURE, FILTERING, COLOR_TEXTURE, FILTERING];

/// A run of triangles and what it is drawn with.
#[derive(Clone, Debug)]
pub(crate) struct MaterialDraw {
    pub indices: Range<u32>,
    pub material: BindGroup,
    pub masked: bool,
    pub double_sided: bool,
}

/// The materials of a scene's draws.
pub(crate) struct Materials {
    /// Those without an alpha test first.
    pub draws: Vec<MaterialDraw>,
    /// `None` where no draw has one.
    pub alpha_tests: Option<AlphaTests>,
    /// Bytes of the textures of `draws`.
    pub texture_bytes: u64,
}

impl Materials {
    /// Those of `scene`, uploaded; `draws` are its runs of triangles.
    pub fn new(
        gpu: &Gpu,
        layout: &BindGroupLayout,
        scene: &Scene,
        draws: &[Draw],
    ) -> Result<Self, RenderError> {
        let mut textures = Textures {
            gpu,
            scene,
            uploaded: HashMap::new(),
            samplers: HashMap::new(),
            texels: Vec::new(),
            bytes: 0,
        };
        let mut material_draws = Vec::with_capacity(draws.len());
        let mut tests: Vec<gpu_structs::AlphaTest> = Vec::new();
        for draw in draws {
            let material = &scene.materials[draw.material];
            let uniform = gpu.device.create_buffer_init(&BufferInitDescriptor {
                label: Some("material"),
                contents: bytemuck::bytes_of(&gpu_structs::Material {
                    base_color: material.base_color.to_array(),
                    metallic: material.metallic,
                    roughness: material.roughness,
                    alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
                    first_triangle: draw.indices.start / 3,
                }),
                usage: BufferUsages::UNIFORM,
            });
            let (base, base_sampler) =
                textures.get(material.base_color_texture, Encoding::Srgb, texel_cutoff(material))?;
            let (surface, surface_sampler) =
                textures.get(material.metallic_roughness_texture, Encoding::Linear, None)?;
            let group = gpu.group(
                "material",
                layout,
                &[
                    uniform.as_entire_binding(),
                    BindingResource::TextureView(&base.view),
                    BindingResource::Sampler(&base_sampler),
                    BindingResource::TextureView(&surface.view),
                    BindingResource::Sampler(&surface_sampler),
                ],
            );
            if let Some(picture) = base.alpha {
                let first_masked = tests.first().map_or(draw.indices.start, |test| test.first_index);
                tests.push(alpha_test(draw, first_masked, material, picture));
            }
            material_draws.push(MaterialDraw {
                indices: draw.indices.clone(),
                material: group,
                masked: material.alpha_cutoff.is_some(),
                double_sided: material.double_sided,
            });
        }
        let Textures { texels, bytes: texture_bytes, .. } = textures;
        let alpha_tests = (!tests.is_empty()).then(|| AlphaTests::new(gpu, tests, texels)).transpose()?;
        Ok(Self { draws: material_draws, alpha_tests, texture_bytes })
    }
}

/// The alpha below which a texel of `material` is a hole where its vertices' alpha is 1. Where it is not from 0 to 1,
/// all texels pass or none.
fn texel_cutoff(material: &Material) -> Option<f32> {
    Some(material.alpha_cutoff? / material.base_color.w)
}

/// What has been uploaded so far; each picture once an encoding and cut-off.
struct Textures<'a> {
    gpu: &'a Gpu,
    scene: &'a Scene,
    /// By image, encoding and the bits of the cut-off.
    uploaded: HashMap<(Option<usize>, Encoding, Option<u32>), Uploaded>,
    samplers: HashMap<Sampler, wgpu::Sampler>,
    /// The alpha of what has a cut-off, each picture's levels one after the other.
    texels: Vec<u8>,
    /// Of all textures.
    bytes: u64,
}

/// A picture on the GPU.
#[derive(Clone, Debug)]
struct Uploaded {
    view: TextureView,
    /// Where it lies among the alpha, if it has a cut-off.
    alpha: Option<AlphaPicture>,
}

impl Textures<'_> {
    /// The picture and sampler of `texture`, or a white texel. With a `cutoff`, mip levels keep the share of the
    /// picture that passes it.
    fn get(
        &mut self,
        texture: Option<TextureRef>,
        encoding: Encoding,
        cutoff: Option<f32>,
    ) -> Result<(Uploaded, wgpu::Sampler), RenderError> {
        let key = (texture.map(|t| t.image), encoding, cutoff.map(f32::to_bits));
        let uploaded = if let Some(uploaded) = self.uploaded.get(&key) {
            uploaded.clone()
        } else {
            let (width, height, rgba8) = key.0.map_or((1, 1, &[255; 4][..]), |index| {
                let image = &self.scene.images[index];
                (image.width, image.height, &image.rgba8)
            });
            let chain = mip_chain(width, height, rgba8, encoding, cutoff);
            let alpha = cutoff.map(|_| {
                let offset = self.texels.len() as u32;
                self.texels.extend(chain.rgba8.iter().skip(3).step_by(4));
                AlphaPicture { offset, width, height, levels: chain.levels }
            });
            let uploaded = Uploaded { view: upload(self.gpu, width, height, &chain, encoding)?, alpha };
            self.bytes += chain.rgba8.len() as u64;
            self.uploaded.insert(key, uploaded.clone());
            uploaded
        };
        let sampler = texture.map(|t| t.sampler).unwrap_or_default();
        let sampler = self.samplers.entry(sampler).or_insert_with(|| create_sampler(self.gpu, sampler));
        Ok((uploaded, sampler.clone()))
    }
}

fn upload(
    gpu: &Gpu,
    width: u32,
    height: u32,
    chain: &MipChain,
    encoding: Encoding,
) -> Result<TextureView, RenderError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    let size = width.max(height);
    if size > limit {
        let what = "the width or height of a texture";
        return Err(RenderError::TooLarge { what, size: f64::from(size), limit: f64::from(limit) });
    }
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some("material texture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: chain.levels,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: match encoding {
                Encoding::Srgb => TextureFormat::Rgba8UnormSrgb,
                Encoding::Linear => TextureFormat::Rgba8Unorm,
            },
            usage: wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        TextureDataOrder::MipMajor,
        &chain.rgba8,
    );
    Ok(texture.create_view(&wgpu::TextureViewDescriptor::default()))
}

fn create_sampler(gpu: &Gpu, sampler: Sampler) -> wgpu::Sampler {
    let address_mode = |wrap| match wrap {
        Wrap::Repeat => wgpu::AddressMode::Repeat,
        Wrap::MirroredRepeat => wgpu::AddressMode::MirrorRepeat,
        Wrap::ClampToEdge => wgpu::AddressMode::ClampToEdge,
    };
    gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("material"),
        address_mode_u: address_mode(sampler.wrap_u),
        address_mode_v: address_mode(sampler.wrap_v),
        mag_filter: if sampler.nearest { wgpu::FilterMode::Nearest } else { wgpu::FilterMode::Linear },
        min_filter: wgpu::FilterMode::Linear,
        mipmap_filter: wgpu::MipmapFilterMode::Linear,
        ..Default::default()
    })
}

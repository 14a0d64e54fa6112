//! Materials on the GPU: one bind group per draw.

use std::collections::HashMap;
use std::ops::Range;

use scene::{Sampler, Scene, TextureRef, Wrap};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, Features, TextureFormat, TextureView};

use super::gpu_structs;
use super::pipeline::{COLOR_TEXTURE, FILTERING, UNIFORM};
use crate::frame::geometry::MaterialRange;
use crate::mipmap::{Encoding, MipChain, TexelFormat, mip_chain};
use crate::{Gpu, RenderError};

/// Group 1 of the passes that draw triangles; see `material.wgsl`.
pub(crate) const BINDINGS: [BindingType; 5] = [UNIFORM, COLOR_TEXTURE, FILTERING, COLOR_TEXTURE, FILTERING];

/// A run of triangles with its material.
#[derive(Clone, Debug)]
pub(crate) struct MaterialDraw {
    pub indices: Range<u32>,
    pub material: BindGroup,
    /// Two flags: true if the material has a color texture, and if it has a metallic-roughness texture.
    pub has_textures: [bool; 2],
    pub is_alpha_tested: bool,
    pub double_sided: bool,
}

pub(crate) struct Materials {
    /// Draws of the scene, one per material in use. Those without an alpha test come first.
    pub draws: Vec<MaterialDraw>,
    pub texture_bytes: u64,
}

impl Materials {
    /// Uploads the materials of `scene`; `draws` are its runs of triangles.
    pub fn new(
        gpu: &Gpu,
        layout: &BindGroupLayout,
        scene: &Scene,
        draws: &[MaterialRange],
    ) -> Result<Self, RenderError> {
        let mut textures = Textures { gpu, scene, uploaded: HashMap::new(), samplers: HashMap::new(), bytes: 0 };
        let mut material_draws = Vec::with_capacity(draws.len());
        for draw in draws {
            let material = &scene.materials[draw.material];
            let (base, base_sampler) = textures.get(material.base_color_texture, Encoding::Srgb)?;
            let (shine, shine_sampler) = textures.get(material.metallic_roughness_texture, Encoding::Linear)?;
            let uniform = gpu.uniform_with(
                "material",
                &gpu_structs::Material {
                    base_color: material.base_color.to_array(),
                    metallic: material.metallic,
                    roughness: material.roughness,
                    alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
                    pad0: 0.0,
                },
            );
            let resources = [
                uniform.as_entire_binding(),
                BindingResource::TextureView(&base),
                BindingResource::Sampler(&base_sampler),
                BindingResource::TextureView(&shine),
                BindingResource::Sampler(&shine_sampler),
            ];
            let group = gpu.bind_group("material", layout, &resources);
            material_draws.push(MaterialDraw {
                indices: draw.indices.clone(),
                material: group,
                has_textures: [material.base_color_texture, material.metallic_roughness_texture]
                    .map(|texture| texture.is_some()),
                is_alpha_tested: material.alpha_cutoff.is_some(),
                double_sided: material.double_sided,
            });
        }
        Ok(Self { draws: material_draws, texture_bytes: textures.bytes })
    }
}

struct Textures<'a> {
    gpu: &'a Gpu,
    scene: &'a Scene,
    /// Uploaded textures, by image and encoding.
    uploaded: HashMap<(Option<usize>, Encoding), TextureView>,
    samplers: HashMap<Sampler, wgpu::Sampler>,
    /// Bytes of all textures.
    bytes: u64,
}

impl Textures<'_> {
    /// Returns the width, height and pixels of `texture`, or a white texel.
    fn image(&self, texture: Option<TextureRef>) -> (u32, u32, &[u8]) {
        texture.map_or((1, 1, &[255; 4]), |texture| {
            let image = &self.scene.images[texture.image];
            (image.width, image.height, &image.rgba8)
        })
    }

    /// Returns the view and sampler of `texture`, which is uploaded at first use.
    fn get(
        &mut self,
        texture: Option<TextureRef>,
        encoding: Encoding,
    ) -> Result<(TextureView, wgpu::Sampler), RenderError> {
        let key = (texture.map(|texture| texture.image), encoding);
        let view = if let Some(view) = self.uploaded.get(&key) {
            view.clone()
        } else {
            let (width, height, rgba8) = self.image(texture);
            let format = format(self.gpu, encoding);
            let chain = self.gpu.host.run_in_background(|| mip_chain((width, height), rgba8, encoding, format))?;
            let view = upload(self.gpu, width, height, &chain)?;
            self.bytes += chain.bytes.len() as u64;
            self.uploaded.insert(key, view.clone());
            view
        };
        let sampler = texture.map(|texture| texture.sampler).unwrap_or_default();
        let sampler = self.samplers.entry(sampler).or_insert_with(|| create_sampler(self.gpu, sampler));
        Ok((view, sampler.clone()))
    }
}

/// Returns the texture format of an encoding. Colors are decoded once and stored as linear values. Samplers decode sRGB
/// approximately, while 16 bits round by at most a fortieth of the smallest step of sRGB. A device without such a
/// format uses halves, which round by at most 1/2048 of a color.
fn format(gpu: &Gpu, encoding: Encoding) -> TexelFormat {
    match encoding {
        Encoding::Linear => TexelFormat::Unorm8,
        Encoding::Srgb if gpu.device.features().contains(Features::TEXTURE_FORMAT_16BIT_NORM) => TexelFormat::Unorm16,
        Encoding::Srgb => TexelFormat::Half,
    }
}

fn texture_format(format: TexelFormat) -> TextureFormat {
    match format {
        TexelFormat::Unorm8 => TextureFormat::Rgba8Unorm,
        TexelFormat::Unorm16 => TextureFormat::Rgba16Unorm,
        TexelFormat::Half => TextureFormat::Rgba16Float,
    }
}

fn upload(gpu: &Gpu, width: u32, height: u32, chain: &MipChain) -> Result<TextureView, RenderError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    RenderError::check_size("the width or height of a texture", width.max(height).into(), limit.into())?;
    Ok(gpu.texture_with(
        "material texture",
        [width, height],
        (texture_format(chain.format), chain.levels),
        &chain.bytes,
    ))
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

//! Materials on the GPU: one bind group per draw.

use std::collections::HashMap;
use std::ops::Range;

use relight::{MaterialRun, SampledTexture, SurfaceMaterial, SurfaceMaterials, TexelWrap, Texels, Texture};
use scene::{Material, Sampler, Scene, TextureRef, Wrap};
use wgpu::{BindGroup, BindGroupLayout, BindingResource, BindingType, Features, TextureFormat, TextureView};

use crate::alpha_test::{AlphaPicture, GpuAlphaTests, alpha_test};
use crate::geometry::MaterialRange;
use crate::mipmap::{Encoding, MipChain, mip_chain};
use crate::pipeline::{COLOR_TEXTURE, FILTERING, UNIFORM};
use crate::{Gpu, RenderError, gpu_structs};

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
    /// `None` if no draw is alpha-tested.
    pub alpha_tests: Option<GpuAlphaTests>,
    /// Same materials in CPU memory, for the native backend; `None` on the wgpu backend.
    pub host: Option<SurfaceMaterials>,
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
        let mut textures = Textures {
            gpu,
            scene,
            uploaded: HashMap::new(),
            samplers: HashMap::new(),
            alpha: HashMap::new(),
            texels: Vec::new(),
            bytes: 0,
            host: gpu.if_native(SurfaceMaterials::default),
            in_host: HashMap::new(),
        };
        let mut material_draws = Vec::with_capacity(draws.len());
        let mut tests: Vec<gpu_structs::AlphaTest> = Vec::new();
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
            textures.add_host_run(draw, material)?;
            if material.alpha_cutoff.is_some() {
                let picture = textures.alpha(material.base_color_texture);
                let first_masked = tests.first().map_or(draw.indices.start, |test| test.first_index);
                tests.push(alpha_test(draw, first_masked, material, picture));
            }
            material_draws.push(MaterialDraw {
                indices: draw.indices.clone(),
                material: group,
                has_textures: [material.base_color_texture, material.metallic_roughness_texture]
                    .map(|texture| texture.is_some()),
                is_alpha_tested: material.alpha_cutoff.is_some(),
                double_sided: material.double_sided,
            });
        }
        let Textures { texels, bytes: texture_bytes, host, .. } = textures;
        let alpha_tests = (!tests.is_empty()).then(|| GpuAlphaTests::new(gpu, tests, texels)).transpose()?;
        Ok(Self { draws: material_draws, alpha_tests, host, texture_bytes })
    }
}

struct Textures<'a> {
    gpu: &'a Gpu,
    scene: &'a Scene,
    /// Uploaded textures, by image and encoding.
    uploaded: HashMap<(Option<usize>, Encoding), TextureView>,
    samplers: HashMap<Sampler, wgpu::Sampler>,
    /// Position of each image's alpha in `texels`.
    alpha: HashMap<Option<usize>, AlphaPicture>,
    /// Alpha of all alpha-tested textures, one after another.
    texels: Vec<u8>,
    /// Bytes of all textures.
    bytes: u64,
    host: Option<SurfaceMaterials>,
    /// Index of each image in the textures of `host`, by encoding.
    in_host: HashMap<(usize, Encoding), usize>,
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
            let chain = self.gpu.run_in_background(|| mip_chain((width, height), rgba8, encoding, format))?;
            let view = upload(self.gpu, width, height, &chain)?;
            self.bytes += chain.bytes.len() as u64;
            let (of_processor, image) = (host_format(encoding), texture.map(|texture| texture.image));
            if let Some(image) = image.filter(|_| chain.format == of_processor) {
                self.add_host_texture(image, encoding, [width, height], &chain);
            }
            self.uploaded.insert(key, view.clone());
            view
        };
        let sampler = texture.map(|texture| texture.sampler).unwrap_or_default();
        let sampler = self.samplers.entry(sampler).or_insert_with(|| create_sampler(self.gpu, sampler));
        Ok((view, sampler.clone()))
    }

    /// Adds a run of triangles to the materials in CPU memory, if there are any.
    fn add_host_run(&mut self, draw: &MaterialRange, material: &Material) -> Result<(), RenderError> {
        if self.host.is_none() {
            return Ok(());
        }
        let base_color_texture = self.host_texture(material.base_color_texture, Encoding::Srgb)?;
        let metallic_roughness_texture = self.host_texture(material.metallic_roughness_texture, Encoding::Linear)?;
        let material = SurfaceMaterial {
            base_color: material.base_color.to_array(),
            metallic: material.metallic,
            roughness: material.roughness,
            base_color_texture,
            metallic_roughness_texture,
        };
        let run = MaterialRun { end: draw.indices.end / 3, material };
        self.host.as_mut().into_iter().for_each(|host| host.runs.push(run));
        Ok(())
    }

    /// Returns a texture of the materials in CPU memory, which is made at first use.
    fn host_texture(
        &mut self,
        texture: Option<TextureRef>,
        encoding: Encoding,
    ) -> Result<Option<SampledTexture>, RenderError> {
        let Some(TextureRef { image, sampler }) = texture else { return Ok(None) };
        if !self.in_host.contains_key(&(image, encoding)) {
            // The device has the texture in another format.
            let picture = &self.scene.images[image];
            let size = [picture.width, picture.height];
            let make = || mip_chain(size.into(), &picture.rgba8, encoding, host_format(encoding));
            let chain = self.gpu.run_in_background(make)?;
            self.add_host_texture(image, encoding, size, &chain);
        }
        let index = self.in_host[&(image, encoding)];
        let Sampler { wrap_u, wrap_v, nearest } = sampler;
        let [wrap_u, wrap_v] = [wrap_u, wrap_v].map(|wrap| match wrap {
            Wrap::Repeat => TexelWrap::Repeat,
            Wrap::MirroredRepeat => TexelWrap::MirroredRepeat,
            Wrap::ClampToEdge => TexelWrap::ClampToEdge,
        });
        Ok(Some(SampledTexture { texture: index, wrap_u, wrap_v, nearest }))
    }

    /// Adds a texture in the format of [`host_format`] to the materials in CPU memory, if there are any.
    fn add_host_texture(&mut self, image: usize, encoding: Encoding, size: [u32; 2], chain: &MipChain) {
        let Some(host) = &mut self.host else { return };
        let texels = match encoding {
            Encoding::Linear => Texels::Unorm8(bytemuck::pod_collect_to_vec(&chain.bytes)),
            Encoding::Srgb => Texels::Unorm16(bytemuck::pod_collect_to_vec(&chain.bytes)),
        };
        self.in_host.insert((image, encoding), host.textures.len());
        host.textures.push(Texture::new(size, texels));
    }

    fn alpha(&mut self, texture: Option<TextureRef>) -> AlphaPicture {
        let key = texture.map(|texture| texture.image);
        if let Some(picture) = self.alpha.get(&key) {
            return *picture;
        }
        let (width, height, rgba8) = self.image(texture);
        let alpha: Vec<u8> = rgba8.iter().skip(3).step_by(4).copied().collect();
        let picture = AlphaPicture { offset: self.texels.len() as u32, width, height };
        self.texels.extend(alpha);
        self.alpha.insert(key, picture);
        picture
    }
}

/// Returns the format of an encoding in CPU memory.
fn host_format(encoding: Encoding) -> TextureFormat {
    match encoding {
        Encoding::Linear => TextureFormat::Rgba8Unorm,
        Encoding::Srgb => TextureFormat::Rgba16Unorm,
    }
}

/// Returns the texture format of an encoding. Colors are decoded once and stored as linear values. Samplers decode sRGB
/// approximately, while 16 bits round by at most a fortieth of the smallest step of sRGB. A device without such a
/// format uses halves, which round by at most 1/2048 of a color.
fn format(gpu: &Gpu, encoding: Encoding) -> TextureFormat {
    match encoding {
        Encoding::Linear => TextureFormat::Rgba8Unorm,
        Encoding::Srgb if gpu.device.features().contains(Features::TEXTURE_FORMAT_16BIT_NORM) => {
            TextureFormat::Rgba16Unorm
        }
        Encoding::Srgb => TextureFormat::Rgba16Float,
    }
}

fn upload(gpu: &Gpu, width: u32, height: u32, chain: &MipChain) -> Result<TextureView, RenderError> {
    let limit = gpu.device.limits().max_texture_dimension_2d;
    RenderError::check_size("the width or height of a texture", width.max(height).into(), limit.into())?;
    Ok(gpu.texture_with("material texture", [width, height], (chain.format, chain.levels), &chain.bytes))
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

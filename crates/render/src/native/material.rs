//! Materials in CPU memory.

use std::collections::HashMap;

use relight::{MaterialRun, SampledTexture, SurfaceMaterial, SurfaceMaterials, Texels, Texture};
use scene::{Sampler, Scene, TextureRef};

use crate::RenderError;
use crate::frame::geometry::Vertices;
use crate::frame::texel_wrap;
use crate::mipmap::{Encoding, TexelFormat, mip_chain};
use crate::native::Cpu;

/// Materials of a scene in CPU memory.
#[derive(Debug)]
pub(crate) struct HostMaterials {
    pub materials: SurfaceMaterials,
    /// One bit per triangle, in words of 32 triangles: set if the triangle is seen from both sides.
    pub both_sides: Vec<u32>,
}

impl HostMaterials {
    pub fn new(cpu: &Cpu, scene: &Scene, vertices: &Vertices) -> Result<Self, RenderError> {
        let mut textures = Textures { cpu, scene, made: HashMap::new(), list: Vec::new() };
        let (mut runs, mut both_sides) = (Vec::new(), vec![0; vertices.planes.len().div_ceil(32)]);
        for draw in &vertices.draws {
            let material = &scene.materials[draw.material];
            let base_color_texture = textures.get(material.base_color_texture, Encoding::Srgb)?;
            let metallic_roughness_texture = textures.get(material.metallic_roughness_texture, Encoding::Linear)?;
            let surface = SurfaceMaterial {
                base_color: material.base_color.to_array(),
                metallic: material.metallic,
                roughness: material.roughness,
                base_color_texture,
                metallic_roughness_texture,
            };
            let triangles = draw.indices.start as usize..draw.indices.end as usize;
            let is_colored = |vertex: &u32| vertices.attributes[*vertex as usize].color != [1.0; 4];
            let has_colors = vertices.indices[triangles].iter().any(is_colored);
            runs.push(MaterialRun { end: draw.indices.end / 3, has_colors, material: surface });
            if material.double_sided {
                for triangle in draw.indices.start / 3..draw.indices.end / 3 {
                    both_sides[triangle as usize / 32] |= 1 << (triangle % 32);
                }
            }
        }
        Ok(Self { materials: SurfaceMaterials { runs, textures: textures.list }, both_sides })
    }

    pub fn bytes(&self) -> u64 {
        self.materials.bytes() + size_of_val(&self.both_sides[..]) as u64
    }
}

struct Textures<'a> {
    cpu: &'a Cpu,
    scene: &'a Scene,
    /// Index of each image in `list`, by encoding.
    made: HashMap<(usize, Encoding), usize>,
    list: Vec<Texture>,
}

impl Textures<'_> {
    /// Returns a texture, which is made at first use. Colors are decoded once and stored as linear values of 16 bits,
    /// which round by at most a fortieth of the smallest step of sRGB.
    fn get(&mut self, texture: Option<TextureRef>, encoding: Encoding) -> Result<Option<SampledTexture>, RenderError> {
        let Some(TextureRef { image, sampler }) = texture else { return Ok(None) };
        let index = if let Some(index) = self.made.get(&(image, encoding)) {
            *index
        } else {
            let picture = &self.scene.images[image];
            let size = [picture.width, picture.height];
            let format = match encoding {
                Encoding::Linear => TexelFormat::Unorm8,
                Encoding::Srgb => TexelFormat::Unorm16,
            };
            let make = || mip_chain(size.into(), &picture.rgba8, encoding, format);
            let chain = self.cpu.host.run_in_background(make)?;
            let texels = match encoding {
                Encoding::Linear => Texels::Unorm8(bytemuck::pod_collect_to_vec(&chain.bytes)),
                Encoding::Srgb => Texels::Unorm16(bytemuck::pod_collect_to_vec(&chain.bytes)),
            };
            self.made.insert((image, encoding), self.list.len());
            self.list.push(Texture::new(size, texels));
            self.list.len() - 1
        };
        let Sampler { wrap_u, wrap_v, nearest } = sampler;
        let [wrap_u, wrap_v] = [wrap_u, wrap_v].map(texel_wrap);
        Ok(Some(SampledTexture { texture: index, wrap_u, wrap_v, nearest }))
    }
}

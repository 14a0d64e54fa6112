//! Import of materials, their pictures and their texture coordinates.

use std::collections::BTreeMap;

use glam::{Affine2, Mat2, Vec2, Vec4};
use gltf::json;
use gltf::json::material::AlphaMode;
use gltf::json::texture::{Info, MagFilter, WrappingMode};
use gltf::json::validation::Checked;
use scene::{Image, Sampler, TextureRef, Wrap};

use super::{ImportReport, ImportSource, display_name, images};
use crate::AssetFault;
use crate::fault::invalid_gltf;

/// Material, and the texture coordinates that its primitives need.
#[derive(Debug)]
pub struct ImportedMaterial {
    pub material: scene::Material,
    /// Texture coordinates that all pictures of the material use.
    pub coordinates: Coordinates,
}

/// Set of texture coordinates, with its `KHR_texture_transform`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    /// The `n` of `TEXCOORD_n`.
    pub set: u32,
    /// Transform from stored coordinates to those in the picture.
    pub picture_from_stored: Affine2,
}

/// Returns the pictures and all materials in file order, followed by glTF's default material.
pub fn read(
    source: &ImportSource,
    report: &mut ImportReport,
) -> Result<(Vec<Image>, Vec<ImportedMaterial>), AssetFault> {
    let mut pictures = ImageCache::default();
    let mut materials = Vec::new();
    for (index, material) in source.root.materials.iter().enumerate() {
        materials.push(pictures.material(source, index, material, report)?);
    }
    materials.push(ImportedMaterial {
        material: scene::Material { name: "default".into(), metallic: 1.0, ..Default::default() },
        coordinates: coordinates(None),
    });
    Ok((pictures.images, materials))
}

#[derive(Default)]
struct ImageCache {
    images: Vec<Image>,
    /// Index in `images` by index in the file. Each picture is decoded once.
    decoded: BTreeMap<usize, usize>,
}

impl ImageCache {
    fn material(
        &mut self,
        source: &ImportSource,
        index: usize,
        material: &json::Material,
        report: &mut ImportReport,
    ) -> Result<ImportedMaterial, AssetFault> {
        let pbr = &material.pbr_metallic_roughness;
        let name = display_name(material.name.as_deref(), "material", index);
        note_unsupported_features(material, &name, report);
        let (base, rough) = (pbr.base_color_texture.as_ref(), pbr.metallic_roughness_texture.as_ref());
        if base.is_some() && rough.is_some() && coordinates(base) != coordinates(rough) {
            report.notes.add("all pictures of a material are placed as its base colour is", name.as_str());
        }
        let alpha_cutoff = match material.alpha_mode {
            Checked::Valid(AlphaMode::Mask) => Some(material.alpha_cutoff.unwrap_or_default().0.clamp(0.0, 1.0)),
            Checked::Valid(AlphaMode::Blend) => Some(0.5),
            Checked::Valid(AlphaMode::Opaque) | Checked::Invalid => None,
        };
        Ok(ImportedMaterial {
            material: scene::Material {
                name,
                base_color: Vec4::from_array(pbr.base_color_factor.0).clamp(Vec4::ZERO, Vec4::ONE),
                metallic: pbr.metallic_factor.0.clamp(0.0, 1.0),
                roughness: pbr.roughness_factor.0.clamp(0.0, 1.0),
                base_color_texture: base.map(|info| self.texture(source, info, report)).transpose()?,
                metallic_roughness_texture: rough.map(|info| self.texture(source, info, report)).transpose()?,
                alpha_cutoff,
                double_sided: material.double_sided,
            },
            coordinates: coordinates(base.or(rough)),
        })
    }

    fn texture(
        &mut self,
        source: &ImportSource,
        info: &Info,
        report: &mut ImportReport,
    ) -> Result<TextureRef, AssetFault> {
        let missing = || invalid_gltf("a texture names no picture that can be read");
        let texture = source.root.get(info.index).ok_or_else(missing)?;
        let webp = texture.extensions.as_ref().and_then(|e| e.others.get("EXT_texture_webp")?.get("source")?.as_u64());
        let index = webp.map_or(texture.source.value(), |index| index as usize);
        if index >= source.root.images.len() {
            return Err(missing());
        }
        let image = if let Some(&image) = self.decoded.get(&index) {
            image
        } else {
            self.images.push(images::read(source, index, report)?);
            self.decoded.insert(index, self.images.len() - 1);
            self.images.len() - 1
        };
        let sampler = texture.sampler.and_then(|sampler| source.root.get(sampler)).map(sampler).unwrap_or_default();
        Ok(TextureRef { image, sampler })
    }
}

fn note_unsupported_features(material: &json::Material, name: &str, report: &mut ImportReport) {
    let emits = material.emissive_texture.is_some() || material.emissive_factor.0.iter().any(|&x| x > 0.0);
    let unlit = material.extensions.as_ref().is_some_and(|e| e.unlit.is_some());
    let blend = material.alpha_mode == Checked::Valid(AlphaMode::Blend);
    for (happened, what) in [
        (material.normal_texture.is_some(), "normal maps are not drawn"),
        (material.occlusion_texture.is_some(), "occlusion maps are not drawn"),
        (emits, "glow is not drawn"),
        (unlit, "unlit materials are lit like others"),
        (blend, "see-through materials are drawn solid where at least half opaque"),
    ] {
        if happened {
            report.notes.add(what, name);
        }
    }
}

fn sampler(sampler: &json::texture::Sampler) -> Sampler {
    let wrap = |mode: Checked<WrappingMode>| match mode {
        Checked::Valid(WrappingMode::ClampToEdge) => Wrap::ClampToEdge,
        Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::MirroredRepeat,
        Checked::Valid(WrappingMode::Repeat) | Checked::Invalid => Wrap::Repeat,
    };
    Sampler {
        wrap_u: wrap(sampler.wrap_s),
        wrap_v: wrap(sampler.wrap_t),
        nearest: sampler.mag_filter == Some(Checked::Valid(MagFilter::Nearest)),
    }
}

/// Computes the transform of `KHR_texture_transform`: scale, then rotate, then translate. The direction of
/// rotation follows the extension's example: rotation pi/2, scale 1/2 and offset (0, 1) show the lower left
/// quarter of the picture.
fn coordinates(info: Option<&Info>) -> Coordinates {
    let transform = info.and_then(|i| i.extensions.as_ref()?.texture_transform.as_ref());
    let set = info.map_or(0, |i| i.tex_coord);
    let Some(transform) = transform else {
        return Coordinates { set, picture_from_stored: Affine2::IDENTITY };
    };
    let (sin, cos) = libm::sincosf(transform.rotation.0);
    let turn = Mat2::from_cols(Vec2::new(cos, -sin), Vec2::new(sin, cos));
    let matrix2 = turn * Mat2::from_diagonal(Vec2::from_array(transform.scale.0));
    let picture_from_stored = Affine2 { matrix2, translation: Vec2::from_array(transform.offset.0) };
    Coordinates { set: transform.tex_coord.unwrap_or(set), picture_from_stored }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texture_transform_is_the_extensions_example() {
        let text = r#"{"index": 0, "texCoord": 3, "extensions": {"KHR_texture_transform":
            {"offset": [0, 1], "rotation": 1.57079632679, "scale": [0.5, 0.5]}}}"#;
        let info: Info = json::deserialize::from_str(text).unwrap();
        let Coordinates { set, picture_from_stored } = coordinates(Some(&info));
        assert_eq!(set, 3);
        // The lower left quarter, with v downwards: u from 0 to 1/2, v from 1/2 to 1.
        for corner in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
            let uv = picture_from_stored.transform_point2(corner);
            assert!((-1e-6..=0.500_001).contains(&uv.x) && (0.499_999..=1.000_001).contains(&uv.y), "{uv}");
        }
    }
}

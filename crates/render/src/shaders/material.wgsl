// glTF's metallic-roughness material.

struct Material {
    base_color: vec4f,
    metallic: f32,
    roughness: f32,
    // Fragments with less alpha are not drawn; 0 draws all.
    alpha_cutoff: f32,
    // Index in `planes` of the first triangle drawn with it.
    first_triangle: u32,
    // See texture.wgsl.
    base_color_modes: vec4u,
    metallic_roughness_modes: vec4u,
}

@group(1) @binding(0) var<uniform> material: Material;
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var metallic_roughness_texture: texture_2d<f32>;

// glTF's metallic-roughness material.

struct Material {
    base_color: vec4f,
    metallic: f32,
    roughness: f32,
    // Fragments with smaller alpha are discarded; 0 draws all.
    alpha_cutoff: f32,
}

@group(1) @binding(0) var<uniform> material: Material;
// Decoded to linear values.
@group(1) @binding(1) var base_color_texture: texture_2d<f32>;
@group(1) @binding(2) var base_color_sampler: sampler;
@group(1) @binding(3) var metallic_roughness_texture: texture_2d<f32>;
@group(1) @binding(4) var metallic_roughness_sampler: sampler;

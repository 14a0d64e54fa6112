// Alpha-tested casters, with the alpha test of the G-buffer.

struct MaskedVaryings {
    @builtin(position) clip: vec4f,
    @location(0) uv: vec2f,
    @location(1) alpha: f32,
}

@vertex
fn vs_masked(
    @location(0) position: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
) -> MaskedVaryings {
    return MaskedVaryings(shadow_view.clip_from_scene * vec4f(position, 1.0), uv, color.a);
}

@fragment
fn fs_masked(in: MaskedVaryings) {
    let texel = textureSampleLevel(base_color_texture, base_color_sampler, in.uv, 0.0).a;
    if material.base_color.a * in.alpha * texel < material.alpha_cutoff {
        discard;
    }
}

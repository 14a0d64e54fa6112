// Casters with holes: the same alpha test as in the G-buffer.

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
    // The level is that of the shorter way across what a texel of the map covers: by the longer one, a card that light
    // grazes would lose its holes.
    let size = vec2f(textureDimensions(base_color_texture));
    let dx = dpdx(in.uv);
    let dy = dpdy(in.uv);
    let longer = max(length(dx * size), length(dy * size));
    let area = abs(dx.x * dy.y - dx.y * dy.x) * size.x * size.y;
    let shrink = min(area / max(longer * longer, 1e-30), 1.0);
    let texel = textureSampleGrad(base_color_texture, base_color_sampler, in.uv, dx * shrink, dy * shrink);
    if material.base_color.a * in.alpha * texel.a < material.alpha_cutoff {
        discard;
    }
}

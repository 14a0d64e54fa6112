// Maps linear radiance to a screen: exposure, Khronos PBR Neutral (KhronosGroup/ToneMapping, 2024), then sRGB.

struct Exposure {
    factor: f32,
    // Radiance is limited to this value, so that its product with the factor stays finite.
    brightest: f32,
}

@group(0) @binding(0) var radiance: texture_2d<f32>;
@group(0) @binding(1) var<uniform> exposure: Exposure;

// Hue and color are unchanged up to START; above it, peaks are compressed to 1 and desaturated.
const START: f32 = 0.8 - 0.04;
const DESATURATION: f32 = 0.15;

fn pbr_neutral(linear: vec3f) -> vec3f {
    // Subtracts the reflection of 4 % that a dielectric adds to its base color.
    let low = min(linear.r, min(linear.g, linear.b));
    let color = linear - select(0.04, low - 6.25 * low * low, low < 0.08);
    let peak = max(color.r, max(color.g, color.b));
    if peak < START {
        return color;
    }
    let room = 1.0 - START;
    let new_peak = 1.0 - room * room / (peak + room - START);
    let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    return mix(color * (new_peak / peak), vec3f(new_peak), white);
}

fn shown(linear: vec3f) -> vec4f {
    let exposed = min(linear, vec3f(exposure.brightest)) * exposure.factor;
    return vec4f(srgb_from_linear(saturate(pbr_neutral(exposed))), 1.0);
}

@fragment
fn fs_display(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    return shown(textureLoad(radiance, vec2u(pixel.xy), 0).rgb);
}

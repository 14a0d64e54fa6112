// Contribution of one light to the picture, or one of its AOVs. The shape of light provides `fn sample_light(surface:
// Surface) -> LightSample` and `fn light_profile() -> LightProfile`. Entry points are named after the AOVs. Follows
// profile.wgsl, and links.wgsl or no_links.wgsl. The constant SHADOWED, a bool, precedes this file: true if the light
// casts shadows.

struct LightSample {
    // True if the light's volume contains the surface, in shadow or not; the rest is 0 outside.
    inside: bool,
    place: LightCoords,
    // On a surface perpendicular to the light, without shadow and tint.
    irradiance: vec3f,
    // 1 lit, 0 in shadow.
    visibility: f32,
}

// Largest irradiance that stays finite through the BRDF.
const MAX_IRRADIANCE = 1e30;

fn tinted(f: LightProfile, irradiance: vec3f) -> vec3f {
    return min(irradiance * f.tint, vec3f(MAX_IRRADIANCE));
}

fn light_at(pixel: vec4f) -> LightSample {
    let surface = surface_at(vec2u(pixel.xy));
    if !surface.exists || !is_lit(surface.triangle) {
        return LightSample();
    }
    return sample_light(surface);
}

fn value(light: LightSample, rgb: vec3f) -> vec4f {
    return select(vec4f(0.0), vec4f(rgb, 1.0) * view.sample_weight, light.inside);
}

@fragment
fn fs_beauty(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let surface = surface_at(vec2u(pixel.xy));
    if !surface.exists || !is_lit(surface.triangle) {
        return vec4f(0.0);
    }
    let light = sample_light(surface);
    if !light.inside {
        return vec4f(0.0);
    }
    let f = light_profile();
    let arriving = tinted(f, light.irradiance) * light_profile_arriving(f, light.visibility);
    let lobes = reflected(surface, light.place.direction);
    let radiance = (lobes.diffuse * f.lobes.x + lobes.specular * f.lobes.y) * arriving;
    return vec4f(radiance * view.sample_weight, 0.0);
}

// Draws the layer of a light: scattered and mirrored radiance, before the factors of the whole light, which terms.wgsl
// applies.
@fragment
fn fs_layer(@builtin(position) pixel: vec4f) -> @location(0) vec4u {
    let surface = surface_at(vec2u(pixel.xy));
    if !surface.exists || !is_lit(surface.triangle) {
        return vec4u(0u);
    }
    let light = sample_light(surface);
    if !light.inside {
        return vec4u(0u);
    }
    let arriving = light.irradiance * light_profile_arriving(light_profile(), light.visibility);
    let lobes = reflected(surface, light.place.direction);
    return vec4u(radiance_to_bits(lobes.diffuse * arriving), radiance_to_bits(lobes.specular * arriving));
}

@fragment
fn fs_t(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, vec3f(light.place.t));
}

@fragment
fn fs_vw(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, vec3f(light.place.vw, 0.0));
}

@fragment
fn fs_direction(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, light.place.direction);
}

@fragment
fn fs_visibility(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, vec3f(light.visibility));
}

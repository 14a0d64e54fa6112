// What one light adds to the picture, or one of its own quantities. Each kind of light brings
// `fn sample_light(surface: Surface) -> LightSample`; the entry points are named after the AOVs.

struct LightSample {
    // Whether the light's volume holds the surface, shadow or not; the rest is 0 outside.
    inside: bool,
    t: f32,
    vw: vec2f,
    // Unit vector from the surface towards the arriving light.
    to_light: vec3f,
    // Perpendicular to `to_light`, without the shadow.
    irradiance: vec3f,
    // 1 lit, 0 in shadow.
    visibility: f32,
}

fn light_at(pixel: vec4f) -> LightSample {
    let surface = surface_at(vec2u(pixel.xy));
    if !surface.exists {
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
    if !surface.exists {
        return vec4f(0.0);
    }
    let light = sample_light(surface);
    if !light.inside {
        return vec4f(0.0);
    }
    let radiance = reflected(surface, light.to_light) * light.irradiance * light.visibility;
    return vec4f(radiance * view.sample_weight, 0.0);
}

@fragment
fn fs_t(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, vec3f(light.t));
}

@fragment
fn fs_vw(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, vec3f(light.vw, 0.0));
}

@fragment
fn fs_direction(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, light.to_light);
}

@fragment
fn fs_visibility(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let light = light_at(pixel);
    return value(light, vec3f(light.visibility));
}

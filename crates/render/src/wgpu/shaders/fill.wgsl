// Light from everywhere: a hemisphere from `ground` to `sky` by the height of a direction.

struct Fill {
    sky: vec3f,
    ground: vec3f,
}

@group(2) @binding(0) var<uniform> fill: Fill;

fn hemisphere(toward: vec3f) -> vec3f {
    return mix(fill.ground, fill.sky, toward.y * 0.5 + 0.5);
}

@fragment
fn fs_beauty(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let surface = surface_at(vec2u(pixel.xy));
    if !surface.exists {
        return vec4f(0.0);
    }
    // Dielectrics scatter the light around the normal, metals mirror the light around the reflected ray. Both have the
    // base color as their albedo, so a white surface returns the light that it receives.
    let mirrored = reflect(-surface.to_eye, surface.normal);
    let diffuse = hemisphere(surface.normal);
    let specular = hemisphere(mix(mirrored, surface.normal, surface.roughness));
    let radiance = surface.base_color * mix(diffuse, specular, surface.metallic);
    return vec4f(radiance * view.fill_factor, 1.0) * view.sample_weight;
}

// AOVs of the surface itself, for people and for tests.

@fragment
fn fs_depth(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let surface = surface_at(vec2u(pixel.xy));
    return select(vec4f(0.0), vec4f(vec3f(surface.depth), 1.0), surface.exists);
}

@fragment
fn fs_normal(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let surface = surface_at(vec2u(pixel.xy));
    return select(vec4f(0.0), vec4f(surface.normal, 1.0), surface.exists);
}

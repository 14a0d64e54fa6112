// The surface of a pixel, rebuilt from the G-buffer. Every lighting pass starts here.

struct Surface {
    // False in the background; the rest is then 0.
    exists: bool,
    // In scene space.
    position: vec3f,
    // Distance along the view axis.
    depth: f32,
    // Unit normal of the triangle, towards the viewer.
    geometric_normal: vec3f,
    // Unit shading normal.
    normal: vec3f,
    // Distance of the shadow test along `normal`: see gbuffer.wgsl.
    terminator_offset: f32,
    // Index in `planes`.
    triangle: u32,
    // Unit vector towards the viewer.
    to_eye: vec3f,
    // Linear.
    base_color: vec3f,
    metallic: f32,
    // Perceptual: the GGX alpha is its square.
    roughness: f32,
}

@group(1) @binding(0) var gbuffer: texture_2d<u32>;
@group(1) @binding(1) var gbuffer_z: texture_2d<f32>;
@group(1) @binding(2) var gbuffer_offset: texture_2d<f32>;

// Returns the surface in a pixel of the G-buffer. `pixel` counts from the corner of the target.
fn surface_at(pixel: vec2u) -> Surface {
    let packed = textureLoad(gbuffer, pixel, 0);
    if packed.y == 0u {
        return Surface();
    }
    let plane = planes[packed.y - 1u];
    let ray = ray_through(pixel);
    let depth = depth_on(plane, ray, textureLoad(gbuffer_z, pixel, 0).x);

    var surface: Surface;
    surface.exists = true;
    surface.position = ray.origin + depth * ray.direction;
    surface.depth = depth;
    surface.to_eye = -normalize(ray.direction);
    surface.geometric_normal = select(plane.xyz, -plane.xyz, dot(plane.xyz, ray.direction) > 0.0);
    surface.normal = unit_from_bits(packed.x);
    surface.terminator_offset = textureLoad(gbuffer_offset, pixel, 0).x;
    surface.triangle = packed.y - 1u;
    let factors = material_from_bits(packed.zw);
    surface.base_color = factors.color;
    surface.metallic = factors.metallic;
    surface.roughness = factors.roughness;
    return surface;
}

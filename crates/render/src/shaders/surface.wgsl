// The surface that a pixel sees, rebuilt from the G-buffer. Every lighting pass starts here.

struct Surface {
    // False in the background; the rest is then 0.
    exists: bool,
    // Scene space.
    position: vec3f,
    // Distance along the view axis.
    depth: f32,
    // Unit normal of the triangle, towards the viewer.
    geometric_normal: vec3f,
    // Unit shading normal.
    normal: vec3f,
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

// `pixel` counts from the corner of the target.
fn surface_at(pixel: vec2u) -> Surface {
    let packed = textureLoad(gbuffer, pixel, 0);
    if packed.y == 0u {
        return Surface();
    }
    let at = vec2f(pixel) + view.tile_origin;
    let origin = view.ray_origin + at.x * view.ray_origin_dx + at.y * view.ray_origin_dy;
    let direction = view.ray_direction + at.x * view.ray_direction_dx + at.y * view.ray_direction_dy;

    // The rasteriser's depth is right to a few thousandths of a percent; it only serves where the plane is
    // seen edge on.
    let z = textureLoad(gbuffer_z, pixel, 0).x;
    let c = view.depth_from_z;
    let rough_depth = (c.x + c.y * z) / (c.z + c.w * z);
    let plane = planes[packed.y - 1u];
    let closing = dot(plane.xyz, direction);
    let exact_depth = (plane.w - dot(plane.xyz, origin)) / select(closing, 1.0, closing == 0.0);
    let depth = select(clamp(exact_depth, 0.5 * rough_depth, 2.0 * rough_depth), rough_depth, closing == 0.0);

    var surface: Surface;
    surface.exists = true;
    surface.position = origin + depth * direction;
    surface.depth = depth;
    surface.to_eye = -normalize(direction);
    surface.geometric_normal = select(plane.xyz, -plane.xyz, closing > 0.0);
    surface.normal = unit_from_bits(packed.x);
    let factors = material_from_bits(packed.zw);
    surface.base_color = factors.color;
    surface.metallic = factors.metallic;
    surface.roughness = factors.roughness;
    return surface;
}

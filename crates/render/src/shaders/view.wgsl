// The camera of the picture. Everything happens in scene space: world axes, origin at the centre of the
// scene's bounds.

struct View {
    // Reversed z: 1 at the near plane, 0 at the far one. Holds the offset of the sample in its pixel.
    clip_from_scene: mat4x4f,
    // The sample of pixel (x, y) lies on the ray that starts at ray_origin + x ray_origin_dx + y ray_origin_dy;
    // likewise its direction, which advances one unit along the view axis.
    ray_origin: vec3f,
    sample_weight: f32,
    ray_origin_dx: vec3f,
    ray_origin_dy: vec3f,
    ray_direction: vec3f,
    ray_direction_dx: vec3f,
    ray_direction_dy: vec3f,
    // Distance along the view axis = (c.x + c.y z) / (c.z + c.w z).
    depth_from_z: vec4f,
    // The pixel of the picture that the target's first one is.
    tile_origin: vec2f,
}

@group(0) @binding(0) var<uniform> view: View;
// One a triangle: n.xyz . position = w on it, n of length 1 towards its front, or 0 where it has no area.
@group(0) @binding(1) var<storage, read> planes: array<vec4f>;

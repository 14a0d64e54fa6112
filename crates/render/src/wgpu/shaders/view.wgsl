// The camera of the picture. All positions are in scene space: world axes, origin at the center of the scene's bounds.

struct View {
    // Reversed z: 1 at the near plane, 0 at the far one. Includes the offset of the sample in its pixel.
    clip_from_scene: mat4x4f,
    // The sample of pixel (x, y) lies on the ray that starts at ray_origin + x ray_origin_dx + y ray_origin_dy;
    // likewise its direction, which advances one unit along the view axis.
    ray_origin: vec3f,
    sample_weight: f32,
    ray_origin_dx: vec3f,
    // Share of the scene's fill in the beauty: 0 is none, 1 all of it.
    fill_factor: f32,
    ray_origin_dy: vec3f,
    ray_direction: vec3f,
    ray_direction_dx: vec3f,
    ray_direction_dy: vec3f,
    // Distance along the view axis = (c.x + c.y z) / (c.z + c.w z).
    depth_from_z: vec4f,
    // Position of the target's first pixel in the picture.
    tile_origin: vec2f,
}

@group(0) @binding(0) var<uniform> view: View;
// One per triangle: n.xyz . position = w on it, n of length 1 towards its front, or 0 if its area is 0.
@group(0) @binding(1) var<storage, read> planes: array<vec4f>;
// The scene's triangles: three coordinates per vertex, three vertices per triangle, and the normal, uv and color of
// each vertex.
@group(0) @binding(2) var<storage, read> positions: array<f32>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> attributes: array<f32>;

const ATTRIBUTES = 9u;

// Ray through a pixel's sample.
struct ViewRay {
    origin: vec3f,
    // Scaled to one unit along the view axis.
    direction: vec3f,
}

// Returns the ray through a pixel's sample. `pixel` is relative to the corner of the target.
fn ray_through(pixel: vec2u) -> ViewRay {
    let at = vec2f(pixel) + view.tile_origin;
    return ViewRay(
        view.ray_origin + at.x * view.ray_origin_dx + at.y * view.ray_origin_dy,
        view.ray_direction + at.x * view.ray_direction_dx + at.y * view.ray_direction_dy,
    );
}

// Returns the distance along the view axis at which a ray meets the plane of the triangle that was rasterized there at
// depth `z`. The rasterizer's depth is correct to a few thousandths of a percent; it only serves if the plane is seen
// edge on.
fn depth_on(plane: vec4f, ray: ViewRay, z: f32) -> f32 {
    let c = view.depth_from_z;
    let rough = (c.x + c.y * z) / (c.z + c.w * z);
    let closing = dot(plane.xyz, ray.direction);
    let exact = (plane.w - dot(plane.xyz, ray.origin)) / select(closing, 1.0, closing == 0.0);
    return select(clamp(exact, 0.5 * rough, 2.0 * rough), rough, closing == 0.0);
}

// Returns the z of a depth along the view axis. Returns `z`, which is the rasterizer's, if the plane is seen so nearly
// edge on that the depth may have a larger error.
fn z_at(depth: f32, z: f32) -> f32 {
    let c = view.depth_from_z;
    let rough = (c.x + c.y * z) / (c.z + c.w * z);
    let exact = (c.x - c.z * depth) / (c.w * depth - c.y);
    return select(z, exact, abs(depth - rough) <= 0x1p-12 * rough);
}

struct Corners {
    a: vec3f,
    b: vec3f,
    c: vec3f,
}

fn position_of(vertex: u32) -> vec3f {
    return vec3f(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

fn normal_of(vertex: u32) -> vec3f {
    let first = ATTRIBUTES * vertex;
    return vec3f(attributes[first], attributes[first + 1u], attributes[first + 2u]);
}

fn corners_of(triangle: u32) -> Corners {
    let first = 3u * triangle;
    return Corners(position_of(indices[first]), position_of(indices[first + 1u]), position_of(indices[first + 2u]));
}

// Weights of the corners at a point of the triangle's plane, one of them negative outside of it; 0 if the triangle has
// no area.
fn weights_at(corners: Corners, point: vec3f) -> vec3f {
    let ab = corners.b - corners.a;
    let ac = corners.c - corners.a;
    let at = point - corners.a;
    let normal = cross(ab, ac);
    let area2 = dot(normal, normal);
    let beta_gamma = vec2f(dot(cross(at, ac), normal), dot(cross(ab, at), normal)) / max(area2, 1e-37);
    return select(vec3f(0.0), vec3f(1.0 - beta_gamma.x - beta_gamma.y, beta_gamma), area2 > 1e-37);
}

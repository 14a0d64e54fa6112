// Draws mapped alpha-tested triangles into the shadow map. Follows bent_shadow.wgsl and alpha_test.wgsl.
//
// A vertex from clipping or splitting has no uv. Its position in the triangle gives the uv, because both are linear in
// the scene.

@group(0) @binding(1) var<uniform> tube_from_scene: mat4x4f;
// The scene's own vertices and triangles.
@group(0) @binding(2) var<storage, read> positions: array<f32>;
// Nine per vertex: normal, uv, color.
@group(0) @binding(3) var<storage, read> attributes: array<f32>;
@group(0) @binding(4) var<storage, read> indices: array<u32>;
@group(1) @binding(0) var<storage, read> alpha_tests: array<AlphaTest>;
// Eight bits per texel, four per word, lowest bits first.
@group(1) @binding(1) var<storage, read> alpha_texels: array<u32>;

struct MaskedFragment {
    @builtin(position) position: vec4f,
    @location(0) t: f32,
    @location(1) uv: vec2f,
    // Alpha of vertex times material.
    @location(2) alpha: f32,
    @location(3) @interpolate(flat, either) cutoff: f32,
    // `place` and `modes` of the texture's `AlphaPicture`.
    @location(4) @interpolate(flat, either) place: vec3u,
    @location(5) @interpolate(flat, either) modes: vec3u,
}

fn tube_position(vertex: u32) -> vec3f {
    let p = vec4f(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u], 1.0);
    return (tube_from_scene * p).xyz;
}

@vertex
fn vs_bent_masked(
    @location(0) mapped: vec4f,
    @location(1) q: vec3f,
    @location(2) triangle: u32,
) -> MaskedFragment {
    let test = alpha_tests[test_of(triangle)];
    let index = test.first_index + 3u * (triangle - test.first_triangle);
    let corners = vec3u(indices[index], indices[index + 1u], indices[index + 2u]);
    let a = tube_position(corners.x);
    let ab = tube_position(corners.y) - a;
    let ac = tube_position(corners.z) - a;
    let normal = cross(ab, ac);
    let per_area = 1.0 / max(dot(normal, normal), 1e-37);
    let b_share = dot(cross(q - a, ac), normal) * per_area;
    let c_share = dot(cross(ab, q - a), normal) * per_area;
    let at_a = uv_alpha(corners.x);
    let here = at_a + b_share * (uv_alpha(corners.y) - at_a) + c_share * (uv_alpha(corners.z) - at_a);
    var out: MaskedFragment;
    out.position = face_position(mapped);
    out.t = mapped.w;
    out.uv = here.xy;
    out.alpha = test.factor * here.z;
    out.cutoff = test.cutoff;
    let picture = picture_of(test);
    out.place = picture.place;
    out.modes = picture.modes;
    return out;
}

@fragment
fn fs_bent_masked(in: MaskedFragment) -> @builtin(frag_depth) f32 {
    if in.alpha * texel_alpha(AlphaPicture(in.place, in.modes), in.uv) < in.cutoff {
        discard;
    }
    return face_depth(in.t, in.position.y);
}

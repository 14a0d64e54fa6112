// A drawing of a bent shadow map's triangles, with their edges. The clip position is that of bent_shadow.wgsl on one
// face, except for the picture's aspect ratio.

struct Wireframe {
    // Clip units per unit of v and w: the map's square is as large as the picture's shorter side.
    clip_per_vw: vec2f,
    // The segments are a part of the light, whose own t is t_start + t_span t.
    t_start: f32,
    t_span: f32,
    // The t of mapped vertices is relative to map_t_base, over map_t_span.
    map_t_base: f32,
    map_t_span: f32,
}

@group(0) @binding(0) var<uniform> wireframe: Wireframe;
// (V, W, R, t): of the scene's vertices, or three per clipped or split triangle.
@group(0) @binding(1) var<storage, read> mapped: array<vec4f>;
// Three vertex indices per triangle.
@group(0) @binding(2) var<storage, read> whole_indices: array<u32>;

struct Fragment {
    @builtin(position) position: vec4f,
    @location(0) t: f32,
    // Weights of the triangle's corners.
    @location(1) weights: vec3f,
}

fn corner(vwrt: vec4f, index: u32) -> Fragment {
    let weights = vec3f(vec3u(index % 3u) == vec3u(0u, 1u, 2u));
    return Fragment(vec4f(vwrt.xy * wireframe.clip_per_vw, 0.5 * vwrt.z, vwrt.z), vwrt.w, weights);
}

@vertex
fn vs_whole(@builtin(vertex_index) index: u32) -> Fragment {
    return corner(mapped[whole_indices[index]], index);
}

@vertex
fn vs_split(@builtin(vertex_index) index: u32) -> Fragment {
    return corner(mapped[index], index);
}

struct Drawn {
    @location(0) value: vec4f,
    @builtin(frag_depth) depth: f32,
}

@fragment
fn fs_wireframe(in: Fragment) -> Drawn {
    // Distance to each edge in pixels; a line fades over half a pixel to each side.
    let pixels = in.weights / max(fwidth(in.weights), vec3f(1e-30));
    let edge = saturate(1.0 - 2.0 * min(pixels.x, min(pixels.y, pixels.z)));
    let t = wireframe.t_start + wireframe.t_span * (in.t + wireframe.map_t_base);
    return Drawn(vec4f(t, edge, 0.0, 1.0), in.t / wireframe.map_t_span);
}

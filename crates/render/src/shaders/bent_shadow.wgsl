// Draws mapped triangles into the shadow map. Clip position (V, W, R/2, R): a straight cone is an ordinary
// perspective spotlight without tessellation, a constant radius an orthographic one. Depth is t / t_max; t is
// not linear on the map, so the fragment writes it.

struct BentShadow {
    t_max: f32,
}

@group(0) @binding(0) var<uniform> bent_shadow: BentShadow;

struct Fragment {
    @builtin(position) position: vec4f,
    @location(0) t: f32,
}

@vertex
fn vs_bent_shadow(@location(0) mapped: vec4f) -> Fragment {
    return Fragment(vec4f(mapped.xy, 0.5 * mapped.z, mapped.z), mapped.w);
}

@fragment
fn fs_bent_shadow(in: Fragment) -> @builtin(frag_depth) f32 {
    return in.t / bent_shadow.t_max;
}

// A curve with its color and intensity; twin of `light`'s segment.rs. Follows curve.wgsl and emission.wgsl.

struct Segment {
    curve: Curve,
    color_0: vec3f,
    intensity_0: f32,
    color_1: vec3f,
    intensity_1: f32,
    color_2: vec3f,
    intensity_2: f32,
    arc_start: f32,
}

// Returns the emission at u: color times intensity.
fn segment_emission(s: Segment, u: f32) -> vec3f {
    let w = 1.0 - u;
    let basis = vec3f(w * w, 2.0 * w * u, u * u);
    let color = s.color_0 * basis.x + s.color_1 * basis.y + s.color_2 * basis.z;
    let intensity = s.intensity_0 * basis.x + s.intensity_1 * basis.y + s.intensity_2 * basis.z;
    return emission(color, intensity);
}

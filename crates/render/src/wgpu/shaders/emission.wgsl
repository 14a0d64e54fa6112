// Emission of a light; twin of `light`'s emission.rs.

// Returns color times intensity, neither below zero.
fn emission(color: vec3f, intensity: f32) -> vec3f {
    return max(color, vec3f(0.0)) * max(intensity, 0.0);
}

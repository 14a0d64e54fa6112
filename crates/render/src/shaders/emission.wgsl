// What leaves a light, as `light` has it in emission.rs.

// Colour times intensity, neither below zero.
fn emission(color: vec3f, intensity: f32) -> vec3f {
    return max(color, vec3f(0.0)) * max(intensity, 0.0);
}

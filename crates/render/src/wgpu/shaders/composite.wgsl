// Sum of `radiance` and the terms, for a screen. Follows terms.wgsl and display.wgsl.

@fragment
fn fs_composite(@builtin(position) pixel: vec4f) -> @location(0) vec4f {
    let at = vec2u(pixel.xy);
    let from_no_light = textureLoad(radiance, at, 0);
    // Lights contribute nothing to the background.
    let count = select(0u, terms.count, from_no_light.a > 0.0);
    return shown(from_no_light.rgb + sum_at(at, count));
}

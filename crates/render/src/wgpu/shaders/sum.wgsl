// A sum, encoded by radiance_to_bits. Follows terms.wgsl.

@fragment
fn fs_sum(@builtin(position) pixel: vec4f) -> @location(0) vec2u {
    // True for every pixel, because no picture is that high.
    let count = select(0u, terms.count, pixel.y < 0x1p20);
    return radiance_to_bits(sum_at(vec2u(pixel.xy), count));
}

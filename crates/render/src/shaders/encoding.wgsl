// Octahedral unit vectors (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit
// Vectors") in 2 x 16 bits, and the sRGB transfer function (IEC 61966-2-1).

fn sign_or_one(v: vec2f) -> vec2f {
    return select(vec2f(-1.0), vec2f(1.0), v >= vec2f(0.0));
}

fn unit_to_bits(n: vec3f) -> u32 {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (vec2f(1.0) - abs(p.yx)) * sign_or_one(p);
    return pack2x16snorm(select(p, folded, n.z < 0.0));
}

fn unit_from_bits(bits: u32) -> vec3f {
    let p = unpack2x16snorm(bits);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let folded = (vec2f(1.0) - abs(p.yx)) * sign_or_one(p);
    return normalize(vec3f(select(p, folded, z < 0.0), z));
}

fn srgb_from_linear(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

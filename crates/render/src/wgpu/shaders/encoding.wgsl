// Octahedral unit vectors (Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors")
// in 2 x 16 bits, material factors and radiance in 64 bits each, and the sRGB transfer function (IEC 61966-2-1).

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

// Encodes a color and a metallic and roughness factor, each 0 to 1, in 64 bits: 3 x 13, 12 and 13. The color is stored
// as its square roots, close to sRGB and cheap to invert. 8 bits of those would have an error of 3e-3 of a middle gray,
// and 9 of a middle metallic factor one of 2e-3 of its diffuse reflection. Factors that are multiples of a tenth, as
// people set them, are stored exactly.
fn material_to_bits(color: vec3f, metallic: f32, roughness: f32) -> vec2u {
    let roots = vec3u(round(sqrt(color) * 8191.0));
    let shine = vec2u(round(vec2f(metallic * 4090.0, roughness * 8190.0)));
    return vec2u(
        roots.r | (roots.g << 13u) | (roots.b << 26u),
        (roots.b >> 6u) | (shine.x << 7u) | (shine.y << 19u),
    );
}

struct MaterialFactors {
    color: vec3f,
    metallic: f32,
    roughness: f32,
}

fn material_from_bits(bits: vec2u) -> MaterialFactors {
    let blue = (bits.x >> 26u) | ((bits.y & 0x7fu) << 6u);
    let roots = vec3f(vec3u(bits.x & 0x1fffu, (bits.x >> 13u) & 0x1fffu, blue)) / 8191.0;
    return MaterialFactors(roots * roots, f32((bits.y >> 7u) & 0xfffu) / 4090.0, f32(bits.y >> 19u) / 8190.0);
}

// Encodes radiance with one exponent for all three colors, as in EXT_texture_shared_exponent, but with 18 bits for each
// and the exponents of f32. The error of a color is at most 2^-18 of the largest of the three. Below 2^-95 the step
// stays 2^-113, and negative values become 0.
fn radiance_to_bits(radiance: vec3f) -> vec2u {
    let largest = max(radiance.r, max(radiance.g, radiance.b));
    // `largest` is less than 2^(exponent - 94).
    let exponent = clamp(bitcast<u32>(largest) >> 23u, 32u, 254u) - 32u;
    let to_18_bits = bitcast<f32>((239u - exponent) << 23u);
    let rounded = min(vec3u(max(radiance * to_18_bits + 0.5, vec3f(0.0))), vec3u(0x3ffffu));
    return vec2u(rounded.r | (rounded.g << 18u), (rounded.g >> 14u) | (rounded.b << 4u) | (exponent << 22u));
}

fn radiance_from_bits(bits: vec2u) -> vec3f {
    let green = (bits.x >> 18u) | ((bits.y & 0xfu) << 14u);
    let from_18_bits = bitcast<f32>(((bits.y >> 22u) + 15u) << 23u);
    return vec3f(vec3u(bits.x & 0x3ffffu, green, (bits.y >> 4u) & 0x3ffffu)) * from_18_bits;
}

fn srgb_from_linear(c: vec3f) -> vec3f {
    return select(1.055 * pow(c, vec3f(1.0 / 2.4)) - 0.055, 12.92 * c, c <= vec3f(0.0031308));
}

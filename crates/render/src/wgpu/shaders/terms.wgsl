// Sums layers with factors, or sums of layers, in order. Follows encoding.wgsl.
//
// A texel of a layer is a light's scattered and its mirrored radiance, each encoded by radiance_to_bits. The two may
// differ by orders of magnitude at one point, and either may have a factor of zero, so each has an exponent of its own.
// A texel of a sum is radiance.
//
// A constant precedes this file:
//   OF_SUMS  bool  all terms are sums

const TERMS = 8u;

struct Terms {
    // Linear RGB.
    diffuse: array<vec4f, TERMS>,
    specular: array<vec4f, TERMS>,
    count: u32,
}

@group(1) @binding(0) var<uniform> terms: Terms;
@group(1) @binding(1) var term_0: texture_2d<u32>;
@group(1) @binding(2) var term_1: texture_2d<u32>;
@group(1) @binding(3) var term_2: texture_2d<u32>;
@group(1) @binding(4) var term_3: texture_2d<u32>;
@group(1) @binding(5) var term_4: texture_2d<u32>;
@group(1) @binding(6) var term_5: texture_2d<u32>;
@group(1) @binding(7) var term_6: texture_2d<u32>;
@group(1) @binding(8) var term_7: texture_2d<u32>;

fn weighed(term: u32, lobes: vec4u) -> vec3f {
    if OF_SUMS {
        return radiance_from_bits(lobes.xy);
    }
    return terms.diffuse[term].rgb * radiance_from_bits(lobes.xy) + terms.specular[term].rgb * radiance_from_bits(lobes.zw);
}

// Returns the sum of the first `count` terms of a pixel. `count` depends on the pixel, too, for the reason in
// branches.rs.
fn sum_at(pixel: vec2u, count: u32) -> vec3f {
    var total = vec3f(0.0);
    if count > 0u { total += weighed(0u, textureLoad(term_0, pixel, 0)); }
    if count > 1u { total += weighed(1u, textureLoad(term_1, pixel, 0)); }
    if count > 2u { total += weighed(2u, textureLoad(term_2, pixel, 0)); }
    if count > 3u { total += weighed(3u, textureLoad(term_3, pixel, 0)); }
    if count > 4u { total += weighed(4u, textureLoad(term_4, pixel, 0)); }
    if count > 5u { total += weighed(5u, textureLoad(term_5, pixel, 0)); }
    if count > 6u { total += weighed(6u, textureLoad(term_6, pixel, 0)); }
    if count > 7u { total += weighed(7u, textureLoad(term_7, pixel, 0)); }
    return total;
}

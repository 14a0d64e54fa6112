// How the texels around a point are blended. The constant comes before this file:
//   SHADOW_FILTER  u32  one of the FILTER_ constants

const FILTER_NEAREST = 0u;
const FILTER_BILINEAR = 1u;
const FILTER_PCF_3X3 = 2u;

// Share of the second texel in a blend with the first.
fn filter_blend(blend: vec2f) -> vec2f {
    return select(blend, round(blend), SHADOW_FILTER == FILTER_NEAREST);
}

// Sum over four texels, in the order of textureGather, weighted by column and row.
fn weighted(lit: vec4f, columns: vec2f, rows: vec2f) -> f32 {
    return dot(rows, vec2f(dot(columns, lit.wz), dot(columns, lit.xy)));
}

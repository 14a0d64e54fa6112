// Percentage-closer filter: compares each texel by itself, and blends the results. A constant precedes this file:
//   SHADOW_FILTER  u32  one of the FILTER_ constants
// Each shape of light provides, for its own map:
//   struct Receiver      with its position `texel`, relative to the center of the first texel
//   fn lit_texels(receiver: Receiver, corner: vec2f) -> mat2x4f
//                        flags of the four texels from `corner` on that let the light through, in the order of
//                        textureGather: by the map's error alone, and if the scene decides on near casters

const FILTER_NEAREST = 0u;
const FILTER_BILINEAR = 1u;
const FILTER_PCF_3X3 = 2u;

// Returns the share of the second texel in a blend with the first.
fn filter_blend(blend: vec2f) -> vec2f {
    return select(blend, round(blend), SHADOW_FILTER == FILTER_NEAREST);
}

// Flags of the four texels from `first` on that are beyond the map, in the order of textureGather. There are no casters
// there: maps are fitted to them, and floors and walls outside the fit are drawn up to the border.
fn beyond_map(first: vec2f, resolution: vec2f) -> vec4<bool> {
    let columns = first.x + vec4f(0.0, 1.0, 1.0, 0.0);
    let rows = first.y + vec4f(1.0, 1.0, 0.0, 0.0);
    return (min(columns, rows) < vec4f(0.0)) | (columns >= vec4f(resolution.x)) | (rows >= vec4f(resolution.y));
}

// Returns the sum over four texels, in the order of textureGather, weighted by column and row: 1 to the last bit if all
// are lit.
fn weighted(lit: vec4f, columns: vec2f, rows: vec2f) -> f32 {
    return dot(rows, vec2f(dot(columns, lit.wz), dot(columns, lit.xy)));
}

fn weighted_both(lit: mat2x4f, columns: vec2f, rows: vec2f) -> vec2f {
    return vec2f(weighted(lit[0], columns, rows), weighted(lit[1], columns, rows));
}

// Shares of the light that the filter lets through, by both results of `lit_texels`.
fn filtered(receiver: Receiver) -> vec2f {
    let first = floor(receiver.texel);
    let blend = filter_blend(receiver.texel - first);
    if SHADOW_FILTER == FILTER_PCF_3X3 {
        let low = mat2x2f(vec2f(1.0 - blend.x, 1.0), vec2f(1.0 - blend.y, 1.0));
        let high = mat2x2f(vec2f(1.0, blend.x), vec2f(1.0, blend.y));
        let sum = weighted_both(lit_texels(receiver, first + vec2f(-1.0, -1.0)), low[0], low[1])
            + weighted_both(lit_texels(receiver, first + vec2f(1.0, -1.0)), high[0], low[1])
            + weighted_both(lit_texels(receiver, first + vec2f(-1.0, 1.0)), low[0], high[1])
            + weighted_both(lit_texels(receiver, first + vec2f(1.0, 1.0)), high[0], high[1]);
        return sum / 9.0;
    }
    let near = lit_texels(receiver, first);
    return weighted_both(near, vec2f(1.0 - blend.x, blend.x), vec2f(1.0 - blend.y, blend.y));
}

// Returns true if ray tests must decide on near casters, and the map on the rest: where light grazes the surface and
// the texels around do not all let it through. `shares` has both shares of `filtered`.
fn asks_scene(shares: vec2f, grazes: bool) -> bool {
    return grazes && shares.x < 1.0 && shares.y > 0.0;
}

// Returns the share of the light that reaches the surface, from both shares of `filtered` and the result of the ray
// test, if there was one (`asks`).
fn decided(shares: vec2f, asks: bool, is_blocked: bool) -> f32 {
    return select(shares.x, select(shares.y, 0.0, is_blocked), asks);
}

// Tests rays if necessary, and returns the share of the light that reaches the surface, if the last piece of the light
// path, reversed, is the straight `way`.
fn decided_along(surface: Surface, shares: vec2f, grazes: bool, way: vec3f) -> f32 {
    let asks = asks_scene(shares, grazes);
    let asked_way = select(vec3f(0.0), way, asks);
    var met = false;
    if any_in_subgroup(asks) {
        met = is_met(shadow_position(surface), asked_way, surface.triangle, surface.depth);
    }
    return decided(shares, asks, met);
}

// Alpha tests of all materials from one table, for triangles of any material in one draw. What samplers do is done by
// hand: bilinear in a level, linear between levels.

struct AlphaTest {
    // Among the scene's triangles with an alpha test.
    first_triangle: u32,
    // Of that triangle in the scene's indices.
    first_index: u32,
    // What there is less of is a hole; 0 has none.
    cutoff: f32,
    // The material's share of what is compared; vertices and texels have the others.
    factor: f32,
    // Of the finest level's first texel in `alpha_texels`; the others follow.
    offset: u32,
    width: u32,
    height: u32,
    levels: u32,
    // 0 repeats, 1 mirrors, 2 goes on with the edge.
    wrap_u: u32,
    wrap_v: u32,
    // Not 0: magnified texels are not blended.
    nearest: u32,
}

@group(1) @binding(0) var<storage, read> alpha_tests: array<AlphaTest>;
// Eight bits a texel, four to a word, the lowest bits first.
@group(1) @binding(1) var<storage, read> alpha_texels: array<u32>;

fn wrapped(x: i32, size: i32, wrap: u32) -> i32 {
    if wrap == 2u {
        return clamp(x, 0, size - 1);
    }
    let period = select(size, 2 * size, wrap == 1u);
    let inside = ((x % period) + period) % period;
    return min(inside, select(inside, period - 1 - inside, wrap == 1u));
}

// A level of a picture.
struct AlphaLevel {
    offset: u32,
    size: vec2i,
}

fn alpha_level(test: AlphaTest, level: u32) -> AlphaLevel {
    var found = AlphaLevel(test.offset, vec2i(i32(test.width), i32(test.height)));
    for (var i = 0u; i < level; i++) {
        found.offset += u32(found.size.x * found.size.y);
        found.size = max(found.size / 2, vec2i(1));
    }
    return found;
}

fn alpha_texel(test: AlphaTest, level: AlphaLevel, at: vec2i) -> f32 {
    let column = wrapped(at.x, level.size.x, test.wrap_u);
    let row = wrapped(at.y, level.size.y, test.wrap_v);
    let index = level.offset + u32(row * level.size.x + column);
    return f32((alpha_texels[index / 4u] >> (8u * (index % 4u))) & 0xffu) / 255.0;
}

fn alpha_bilinear(test: AlphaTest, level: AlphaLevel, uv: vec2f) -> f32 {
    let at = uv * vec2f(level.size) - 0.5;
    let first = vec2i(floor(at));
    let share = at - floor(at);
    let top = mix(alpha_texel(test, level, first), alpha_texel(test, level, first + vec2i(1, 0)), share.x);
    let bottom =
        mix(alpha_texel(test, level, first + vec2i(0, 1)), alpha_texel(test, level, first + vec2i(1, 1)), share.x);
    return mix(top, bottom, share.y);
}

// The texel's alpha at `uv`, which changes by `dx` and `dy` to the next texels of the map.
//
// The level is that of the shorter way across what a texel of the map covers: by the longer one, as pictures have it, a
// card that light grazes would lose its holes.
fn texel_alpha(test: AlphaTest, uv: vec2f, dx: vec2f, dy: vec2f) -> f32 {
    let size = vec2f(f32(test.width), f32(test.height));
    let longer = max(length(dx * size), length(dy * size));
    let area = abs(dx.x * dy.y - dx.y * dy.x) * size.x * size.y;
    let level = clamp(log2(max(area, 1e-30) / max(longer, 1e-30)), 0.0, f32(test.levels - 1u));
    let fine = alpha_level(test, u32(level));
    if level == 0.0 && test.nearest != 0u {
        return alpha_texel(test, fine, vec2i(floor(uv * size)));
    }
    let alpha = alpha_bilinear(test, fine, uv);
    if fract(level) == 0.0 {
        return alpha;
    }
    return mix(alpha, alpha_bilinear(test, alpha_level(test, u32(level) + 1u), uv), fract(level));
}

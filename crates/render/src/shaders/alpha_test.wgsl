// Alpha tests of all materials from one table, for triangles of any material in one draw. What samplers do is done by
// hand: bilinear in a level, linear between levels. Whoever asks brings
//   alpha_tests   array<AlphaTest>
//   alpha_texels  array<u32>: eight bits a texel, four to a word, the lowest bits first
//   attributes    array<f32>: nine a vertex: normal, uv, colour

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

// The last test that begins at or before a triangle.
fn test_of(triangle: u32) -> u32 {
    var first = 0u;
    var end = arrayLength(&alpha_tests);
    while end - first > 1u {
        let middle = (first + end) / 2u;
        if alpha_tests[middle].first_triangle <= triangle {
            first = middle;
        } else {
            end = middle;
        }
    }
    return first;
}

// What a fragment has to know of a test's picture. Flat, and so a fragment need not look it up.
struct AlphaPicture {
    // Offset, width, height, levels.
    place: vec4u,
    // wrap_u, wrap_v, nearest.
    modes: vec3u,
}

fn picture_of(test: AlphaTest) -> AlphaPicture {
    return AlphaPicture(
        vec4u(test.offset, test.width, test.height, test.levels),
        vec3u(test.wrap_u, test.wrap_v, test.nearest),
    );
}

// Of a vertex: uv and alpha.
fn uv_alpha(vertex: u32) -> vec3f {
    return vec3f(attributes[9u * vertex + 3u], attributes[9u * vertex + 4u], attributes[9u * vertex + 8u]);
}

// Texels that indices along one axis stand for. In floats, which are exact here: dividing integers is slow.
fn wrapped(x: vec2f, size: f32, wrap: u32) -> vec2u {
    let period = select(size, 2.0 * size, wrap == 1u);
    let inside = x - period * floor((x + 0.5) / period);
    let repeated = select(inside, min(inside, period - 1.0 - inside), wrap == 1u);
    return vec2u(clamp(select(repeated, x, wrap == 2u), vec2f(0.0), vec2f(size - 1.0)));
}

// A level of a picture.
struct AlphaLevel {
    offset: u32,
    size: vec2u,
}

fn alpha_level(place: vec4u, level: u32) -> AlphaLevel {
    var found = AlphaLevel(place.x, place.yz);
    for (var i = 0u; i < level; i++) {
        found.offset += found.size.x * found.size.y;
        found.size = max(found.size >> vec2u(1u), vec2u(1u));
    }
    return found;
}

fn alpha_texel(index: u32) -> f32 {
    return f32((alpha_texels[index / 4u] >> (8u * (index % 4u))) & 0xffu) / 255.0;
}

fn alpha_bilinear(modes: vec3u, level: AlphaLevel, uv: vec2f) -> f32 {
    let size = vec2f(level.size);
    let at = uv * size - 0.5;
    let first = floor(at);
    let share = at - first;
    let columns = wrapped(vec2f(first.x, first.x + 1.0), size.x, modes.x);
    let rows = level.offset + wrapped(vec2f(first.y, first.y + 1.0), size.y, modes.y) * level.size.x;
    let top = mix(alpha_texel(rows.x + columns.x), alpha_texel(rows.x + columns.y), share.x);
    let bottom = mix(alpha_texel(rows.y + columns.x), alpha_texel(rows.y + columns.y), share.x);
    return mix(top, bottom, share.y);
}

// The texel's alpha at `uv`, which changes by `dx` and `dy` to the next texels of the map.
//
// The level is that of the shorter way across what a texel of the map covers: by the longer one, as pictures have it, a
// card that light grazes would lose its holes.
fn texel_alpha(picture: AlphaPicture, uv: vec2f, dx: vec2f, dy: vec2f) -> f32 {
    let size = vec2f(picture.place.yz);
    let longer = max(length(dx * size), length(dy * size));
    let area = abs(dx.x * dy.y - dx.y * dy.x) * size.x * size.y;
    let level = clamp(log2(max(area, 1e-30) / max(longer, 1e-30)), 0.0, f32(picture.place.w - 1u));
    let fine = alpha_level(picture.place, u32(level));
    if level == 0.0 && picture.modes.z != 0u {
        let at = floor(uv * size);
        let column = wrapped(at.xx, size.x, picture.modes.x).x;
        let row = wrapped(at.yy, size.y, picture.modes.y).x;
        return alpha_texel(fine.offset + row * fine.size.x + column);
    }
    let alpha = alpha_bilinear(picture.modes, fine, uv);
    if fract(level) == 0.0 {
        return alpha;
    }
    let coarse = alpha_level(picture.place, u32(level) + 1u);
    return mix(alpha, alpha_bilinear(picture.modes, coarse, uv), fract(level));
}

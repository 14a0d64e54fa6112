// Alpha tests of all materials from one table, for triangles of any material in one draw. Textures are sampled at full
// size, bilinearly. The including module declares
//   alpha_tests   array<AlphaTest>
//   alpha_texels  array<u32>: eight bits per texel, four per word, lowest bits first
//   attributes    array<f32>: nine per vertex: normal, uv, color

struct AlphaTest {
    // Index among the scene's alpha-tested triangles.
    first_triangle: u32,
    // Index of that triangle's first corner in the scene's indices.
    first_index: u32,
    // Smaller alpha is a hole; 0 makes no holes.
    cutoff: f32,
    // The material's factor of alpha; vertices and texels have the others.
    factor: f32,
    // Index of the texture's first texel in `alpha_texels`.
    offset: u32,
    width: u32,
    height: u32,
    // Wrap modes along u and v, as `wrapped` numbers them.
    wrap_u: u32,
    wrap_v: u32,
    // Not 0: texels are not blended.
    nearest: u32,
}

// Returns the index of the last test that begins at or before a triangle.
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

// Parameters of a test's texture. They are flat varyings, so a fragment need not look them up.
struct AlphaPicture {
    // Offset, width, height.
    place: vec3u,
    // wrap_u, wrap_v, nearest.
    modes: vec3u,
}

fn picture_of(test: AlphaTest) -> AlphaPicture {
    return AlphaPicture(
        vec3u(test.offset, test.width, test.height),
        vec3u(test.wrap_u, test.wrap_v, test.nearest),
    );
}

// Returns the texture coordinates (u, v) of a vertex, and its alpha.
fn uv_alpha(vertex: u32) -> vec3f {
    return vec3f(attributes[9u * vertex + 3u], attributes[9u * vertex + 4u], attributes[9u * vertex + 8u]);
}

fn alpha_texel(index: u32) -> f32 {
    return f32((alpha_texels[index / 4u] >> (8u * (index % 4u))) & 0xffu) / 255.0;
}

// Returns the texel indices along one axis after wrapping: 0 repeats, 1 mirrors, 2 clamps to the edge. Computed in
// floats, which are exact here, because integer division is slow.
fn wrapped(x: vec2f, size: f32, wrap: u32) -> vec2u {
    let period = select(size, 2.0 * size, wrap == 1u);
    let inside = x - period * floor((x + 0.5) / period);
    let repeated = select(inside, min(inside, period - 1.0 - inside), wrap == 1u);
    return vec2u(clamp(select(repeated, x, wrap == 2u), vec2f(0.0), vec2f(size - 1.0)));
}

// Returns the texture's alpha at `uv`.
fn texel_alpha(picture: AlphaPicture, uv: vec2f) -> f32 {
    let size = vec2f(picture.place.yz);
    let is_nearest = picture.modes.z != 0u;
    let at = uv * size - select(0.5, 0.0, is_nearest);
    let first = floor(at);
    let share = select(at - first, vec2f(0.0), is_nearest);
    let columns = wrapped(vec2f(first.x, first.x + 1.0), size.x, picture.modes.x);
    let rows = picture.place.x
        + wrapped(vec2f(first.y, first.y + 1.0), size.y, picture.modes.y) * picture.place.y;
    let top = mix(alpha_texel(rows.x + columns.x), alpha_texel(rows.x + columns.y), share.x);
    let bottom = mix(alpha_texel(rows.y + columns.x), alpha_texel(rows.y + columns.y), share.x);
    return mix(top, bottom, share.y);
}

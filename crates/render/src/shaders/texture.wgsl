// Pictures of materials, looked up by hand: samplers may decode sRGB by an approximation, llvmpipe's by one that is off by
// 5e-3, and weigh texels in steps of 1/256. Follows wrap.wgsl.
//
// `modes` of a picture: how it goes on along u and v, whether magnified texels are not blended, and how many levels it has,
// 0 where there is none but a white texel.

// t^2.4 is t^2 times a polynomial of the root of t, within 2.2e-6 of itself for each of 256 bytes, whatever a driver's `pow`.
fn linear_from_srgb(c: vec3f) -> vec3f {
    let t = (c + 0.055) / 1.055;
    let s = sqrt(t);
    var p = 0.565740168 - 0.12162034 * s;
    p = p * s - 1.13228417;
    p = p * s + 1.30280372;
    p = p * s - 1.03248783;
    p = p * s + 1.38647573;
    p = p * s + 0.0313705615;
    return select(p * t * t, c / 12.92, c <= vec3f(0.04045));
}

fn texel_at(picture: texture_2d<f32>, column: u32, row: u32, level: u32, is_srgb: bool) -> vec4f {
    let texel = textureLoad(picture, vec2u(column, row), level);
    return vec4f(select(texel.rgb, linear_from_srgb(texel.rgb), is_srgb), texel.a);
}

// Of four texels of a level, blended unless `is_nearest`.
fn texels_at(
    picture: texture_2d<f32>,
    modes: vec4u,
    uv: vec2f,
    level: u32,
    is_nearest: bool,
    is_srgb: bool,
) -> vec4f {
    // Not `textureDimensions(picture, level)`: a driver may take one pixel's level for those around it.
    let size = vec2f(max(textureDimensions(picture) >> vec2u(level), vec2u(1u)));
    let at = uv * size - select(0.5, 0.0, is_nearest);
    let first = floor(at);
    let share = select(at - first, vec2f(0.0), is_nearest);
    let columns = wrapped(vec2f(first.x, first.x + 1.0), size.x, modes.x);
    let rows = wrapped(vec2f(first.y, first.y + 1.0), size.y, modes.y);
    let top = mix(
        texel_at(picture, columns.x, rows.x, level, is_srgb),
        texel_at(picture, columns.y, rows.x, level, is_srgb),
        share.x,
    );
    let bottom = mix(
        texel_at(picture, columns.x, rows.y, level, is_srgb),
        texel_at(picture, columns.y, rows.y, level, is_srgb),
        share.x,
    );
    return mix(top, bottom, share.y);
}

// Alpha at full size, whatever a pixel covers: then many pixels pass a test as often as points of the picture do.
fn alpha_at(picture: texture_2d<f32>, modes: vec4u, uv: vec2f) -> f32 {
    return texels_at(picture, modes, uv, 0u, modes.z != 0u, false).a;
}

// What a pixel covers of a picture, where uv changes by `dx` and `dy` to the next pixels: between the two levels by the longer
// of them. White where there is no picture, or none is seen: in no turn of a loop, which a software driver leaves at once.
fn picture_at(
    picture: texture_2d<f32>,
    modes: vec4u,
    uv: vec2f,
    dx: vec2f,
    dy: vec2f,
    is_srgb: bool,
    is_seen: bool,
) -> vec4f {
    let size = vec2f(textureDimensions(picture));
    let texels = max(length(dx * size), length(dy * size));
    let level = clamp(log2(max(texels, 1.0)), 0.0, f32(max(modes.w, 1u) - 1u));
    let levels = select(1u, 2u, fract(level) > 0.0);
    let end = select(0u, levels, is_seen & (modes.w > 0u));
    var sum = vec4f(select(0.0, 1.0, end == 0u));
    for (var turn = 0u; turn < end; turn++) {
        let share = select(1.0 - fract(level), fract(level), turn > 0u);
        let is_nearest = (modes.z != 0u) & (texels <= 1.0);
        sum += share * texels_at(picture, modes, uv, u32(level) + turn, is_nearest, is_srgb);
    }
    return sum;
}

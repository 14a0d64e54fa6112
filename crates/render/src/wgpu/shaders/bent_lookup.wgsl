// Position of a receiver on the faces of a bent map. Follows tube.wgsl. A constant precedes this file:
//   SHADOW_CUBE  bool  the front of a cube, +V, -V, +W and -W in that order, on which (V, W, R / slope) are like
//                      positions on a straight cone; else one face, uniform in v and w

struct MapTexel {
    face: u32,
    texel: vec2f,
    // Change of (v, w) per texel, to the right and downwards.
    right: vec2f,
    down: vec2f,
    // A face's depth is t times this gain, which on a straight cone is the distance along the face's own axis; and the
    // gain's change per texel downwards.
    gain: f32,
    gain_down: f32,
    // Value of depth 1.
    far: f32,
}

// Returns the center and 1 / half size of the drawn part of a face, as slopes. Selected, not indexed: a software driver
// gathers one number after another.
fn fit_of(face: u32) -> vec4f {
    var fit = light.fits[0];
    if SHADOW_CUBE {
        fit = select(fit, light.fits[1], face == 1u);
        fit = select(fit, light.fits[2], face == 2u);
        fit = select(fit, light.fits[3], face == 3u);
        fit = select(fit, light.fits[4], face == 4u);
    }
    return fit;
}

fn map_texel(vw_len: vec2f, radius_or_zero: f32) -> MapTexel {
    // At the source, the offset is zero.
    let radius = select(1.0, radius_or_zero, radius_or_zero > 0.0);
    let depth = radius / light.slope;
    let aside = abs(vw_len);
    let front = !SHADOW_CUBE || depth >= max(aside.x, aside.y);
    let along_v = aside.x >= aside.y;
    let turned = select(vw_len.yx, vw_len, along_v);
    let ahead = select(abs(turned.x), depth, front);

    var found: MapTexel;
    let side = select(select(4u, 3u, turned.x > 0.0), select(2u, 1u, turned.x > 0.0), along_v);
    found.face = select(side, 0u, front);
    let xy = select(vec2f(turned.y, depth), vw_len, front) / ahead;
    let fit = fit_of(found.face);
    let resolution = light.shadow_resolution;
    found.texel = ((xy - fit.xy) * fit.zw * vec2f(0.5, -0.5) + 0.5) * resolution - 0.5;
    let step = vec2f(2.0, -2.0) / (fit.zw * resolution);
    found.right = vec2f(step.x / light.slope, 0.0);
    found.down = vec2f(0.0, step.y / light.slope);
    found.gain = 1.0;
    found.far = light.map_t_span;
    if !front {
        // On a side, x = w / |v| and y = 1 / (slope |v|), or the same with v and w exchanged.
        let size = ahead / radius;
        let away = -light.slope * size * size * step.y;
        let right = vec2f(0.0, size * step.x);
        let down = vec2f(sign(turned.x), xy.x) * away;
        found.right = select(right.yx, right, along_v);
        found.down = select(down.yx, down, along_v);
        found.gain = light.slope * size;
        found.gain_down = light.slope * away;
        found.far = light.map_t_span * light.slope;
    }
    return found;
}

// The increasing roots of one point on one curve each, for `bendylights-studies solver`. Follows curve.wgsl.

const NEWTON_STEPS = 3u;

fn sdiv(n: f32, d: f32) -> f32 {
    if abs(n) <= 64.0 * abs(d) {
        if d == 0.0 {
            return 0.0;
        }
        return n / d;
    }
    return select(-64.0, 64.0, (n < 0.0) == (d < 0.0));
}

fn cbrt_above(x: f32) -> f32 {
    return bitcast<f32>(bitcast<u32>(x) / 3u + 709921077u) * 1.06;
}

struct Cubic {
    c1: f32,
    c2: f32,
    c3: f32,
}

fn cubic_slope(c: Cubic, u: f32) -> f32 {
    return (3.0 * c.c3 * u + 2.0 * c.c2) * u + c.c1;
}

fn cubic_half_curvature(c: Cubic, u: f32) -> f32 {
    return 3.0 * c.c3 * u + c.c2;
}

fn climb(f: f32, g: f32, h: f32, a: f32, t_max: f32) -> f32 {
    var t = t_max;
    if f < g * t {
        t = f / g;
    }
    if f < h * t * t {
        t = sqrt(f / h);
    }
    if f < a * t * t * t {
        t = min(cbrt_above(f / a), t);
    }
    for (var i = 0u; i < NEWTON_STEPS; i++) {
        let value = ((a * t + h) * t + g) * t - f;
        let slope = (3.0 * a * t + 2.0 * h) * t + g;
        if slope > 0.0 {
            t = clamp(t - value / slope, 0.0, t_max);
        }
    }
    return t;
}

fn polish(c: Curve, q: vec3f, u: f32, low: f32, high: f32) -> f32 {
    let r = curve_offset(c, q, u);
    let d = curve_d(c, u);
    let n = dot(r, d);
    let slope = 2.0 * dot(d, d) - dot(r, c.a);
    var step = 0.0;
    // Limited to steps over which the slope changes by less than half: near a cusp both n and the slope may be rounding
    // noise.
    let half_curvature = 3.0 * dot(c.a, d);
    if abs(n) <= slope * 0.015625 && abs(n * half_curvature) <= 0.25 * slope * slope && slope > 0.0 {
        step = n / slope;
    }
    return clamp(u + step, low, high);
}

struct Roots {
    left: f32,
    right: f32,
    has_left: bool,
    has_right: bool,
}

// Returns the value of f at a split point between pieces: at an end of the segment the caller's value, inside that of
// the cubic.
fn at_split(u: f32, start: f32, end: f32, inside: f32) -> f32 {
    return select(select(inside, end, u == 1.0), start, u == 0.0);
}

// Returns half the derivative of the squared distance.
fn f_at(c: Curve, q: vec3f, u: f32) -> f32 {
    return -dot(curve_offset(c, q, u), curve_d(c, u));
}

fn increasing_roots(c: Curve, q: vec3f, f0: f32, f1: f32) -> Roots {
    let from_start = q - c.b0;
    let cubic = Cubic(
        2.0 * dot(c.d0, c.d0) - dot(from_start, c.a),
        3.0 * dot(c.d0, c.a),
        dot(c.a, c.a),
    );
    let e0 = select(-dot(from_start, c.a), f0, dot(c.d0, c.d0) > 0.0);
    let e1 = select(dot(q - c.b2, c.a), f1, dot(c.d1, c.d1) > 0.0);

    var cl: f32;
    var ch: f32;
    let discriminant = cubic.c2 * cubic.c2 - 3.0 * cubic.c3 * cubic.c1;
    if discriminant > 0.0 {
        let root = sqrt(discriminant);
        let qd = -(cubic.c2 + select(root, -root, cubic.c2 < 0.0));
        let x = sdiv(qd, 3.0 * cubic.c3);
        let y = sdiv(cubic.c1, qd);
        cl = saturate(min(x, y));
        ch = saturate(max(x, y));
    } else {
        cl = saturate(sdiv(-cubic.c2, 3.0 * cubic.c3));
        ch = cl;
    }

    // Computed from the geometry: near P' = 0 the roots are so close together that the rounding of the coefficients
    // exceeds all values of f between them.
    let fl = at_split(cl, f0, f1, f_at(c, q, cl));
    let fh = at_split(ch, f0, f1, min(f_at(c, q, ch), fl));
    let sl = at_split(cl, e0, e1, fl);
    let sh = at_split(ch, e0, e1, fh);

    // A piece without length counts only if f rises there.
    var roots = Roots(0.0, 0.0, false, false);
    if e0 <= 0.0 && 0.0 <= sl && (cl > 0.0 || cubic_slope(cubic, cl) >= 0.0) {
        let g = max(cubic_slope(cubic, cl), 0.0);
        let h = max(-cubic_half_curvature(cubic, cl), 0.0);
        let u = cl - climb(abs(fl), g, h, cubic.c3, cl);
        roots.left = polish(c, q, u, 0.0, cl);
        roots.has_left = true;
    }
    if sh <= 0.0 && 0.0 <= e1 && (ch < 1.0 || cubic_slope(cubic, ch) >= 0.0) {
        let g = max(cubic_slope(cubic, ch), 0.0);
        let h = max(cubic_half_curvature(cubic, ch), 0.0);
        let u = ch + climb(abs(fh), g, h, cubic.c3, 1.0 - ch);
        roots.right = polish(c, q, u, ch, 1.0);
        roots.has_right = true;
    }
    return roots;
}

// Arc length of a curve; twin of `light`'s arc.rs. Follows curve.wgsl.

// Abscissae and weights of light::GAUSS_LEGENDRE.
const GAUSS_LEGENDRE = array<vec2f, 4>(
    vec2f(0.18343464, 0.36268377),
    vec2f(0.5255324, 0.31370664),
    vec2f(0.7966665, 0.22238104),
    vec2f(0.96028984, 0.101228535),
);

fn arc_quadrature(c: Curve, start: f32, end: f32) -> f32 {
    let middle = (start + end) * 0.5;
    let half = (end - start) * 0.5;
    var sum = 0.0;
    for (var k = 0u; k < 4u; k++) {
        let rule = GAUSS_LEGENDRE[k];
        sum += rule.y * (length(curve_d(c, middle - half * rule.x)) + length(curve_d(c, middle + half * rule.x)));
    }
    return 2.0 * half * sum;
}

// Computes the arc length of the center curve from the segment's start to u.
fn arc_length(c: Curve, u: f32) -> f32 {
    let aa = dot(c.a, c.a);
    let valley = -dot(c.d0, c.a);
    if valley > 0.0 && valley < u * aa {
        let split = valley / aa;
        return arc_quadrature(c, 0.0, split) + arc_quadrature(c, split, u);
    }
    return arc_quadrature(c, 0.0, u);
}

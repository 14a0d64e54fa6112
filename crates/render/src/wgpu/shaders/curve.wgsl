// One quadratic piece of a tube; twin of `light`'s curve.rs, see twins.rs. Every division is guarded: WGSL guarantees
// neither NaN nor infinity.

struct Curve {
    b0: vec3f,
    r0: f32,
    b2: vec3f,
    e0: f32,
    d0: vec3f,
    ar: f32,
    d1: vec3f,
    alpha: f32,
    a: vec3f,
    beta: f32,
    n_hat: vec3f,
    t_start: f32,
    box_center: vec3f,
    t_span: f32,
    box_axis_0: vec3f,
    box_half_0: f32,
    box_axis_1: vec3f,
    box_half_1: f32,
    box_axis_2: vec3f,
    box_half_2: f32,
}

fn curve_d(c: Curve, u: f32) -> vec3f {
    return select(c.d0 + c.a * u, c.d1, u == 1.0);
}

fn curve_offset(c: Curve, q: vec3f, u: f32) -> vec3f {
    return (q - c.b0) - (c.d0 * 2.0 + c.a * u) * u;
}

fn curve_radius(c: Curve, u: f32) -> f32 {
    return c.r0 + u * (2.0 * c.e0 + u * c.ar);
}

fn curve_radius_derivative(c: Curve, u: f32) -> f32 {
    return 2.0 * (c.e0 + u * c.ar);
}

// Returns the unit tangent; the one-sided limit where P' is zero at an end.
fn curve_u_hat(c: Curve, u: f32) -> vec3f {
    let d = curve_d(c, u);
    if dot(d, d) > 0.0 {
        return normalize(d);
    }
    return normalize(select(-c.a, c.a, u < 0.5));
}

// Returns the derivative of the unit tangent, from half the first and the second derivative of position.
fn curve_u_hat_derivative(d: vec3f, a: vec3f, u_hat: vec3f) -> vec3f {
    let speed = length(d);
    if speed > 0.0 {
        return (a - u_hat * dot(a, u_hat)) / speed;
    }
    return vec3f(0.0);
}

// Returns v_hat and w_hat of the rotation-minimizing frame, as the columns of a matrix.
fn curve_rotation_minimizing(c: Curve, u_hat: vec3f) -> mat2x3f {
    let m = cross(c.n_hat, u_hat);
    return mat2x3f(c.n_hat * c.alpha + m * c.beta, c.n_hat * c.beta - m * c.alpha);
}

fn tube_box_contains(c: Curve, q: vec3f) -> bool {
    let p = q - c.box_center;
    return abs(dot(p, c.box_axis_0)) <= c.box_half_0
        && abs(dot(p, c.box_axis_1)) <= c.box_half_1
        && abs(dot(p, c.box_axis_2)) <= c.box_half_2;
}

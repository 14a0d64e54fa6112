// A BendyLight and where a point lies in it: the twin of bendy's tube.rs and arc.rs. Follows curve.wgsl.
// Positions `q` are in tube space; the caller goes there with a matrix composed in f64.

struct Segment {
    curve: Curve,
    color_0: vec3f,
    intensity_0: f32,
    color_1: vec3f,
    intensity_1: f32,
    color_2: vec3f,
    intensity_2: f32,
    arc_start: f32,
}

struct BendyLight {
    // Columns; the translation is in the last one.
    tube_from_scene: mat4x4f,
    // Rotation only.
    world_from_tube: mat3x3f,
    up: vec3f,
    // Number of quadratic segments; one more follows where the light is extended.
    segment_count: u32,
    extended: u32,
    frame_up: u32,
    direction_path: u32,
    decay: u32,
    world_per_tube: f32,
    // The shadow map's depth is t / t_max.
    t_max: f32,
    shadow_resolution: f32,
    tan2_outer: f32,
    cos_outer: f32,
    inv_cos_range: f32,
}

@group(2) @binding(0) var<uniform> light: BendyLight;
@group(2) @binding(1) var<storage, read> segments: array<Segment>;

const JOINT_MERGE = 1e-5;
const DIRECTION_FLOOR = 1e-18;
const DECAY_NONE = 0u;
const DECAY_LINEAR = 1u;

struct Root {
    found: bool,
    segment: u32,
    u: f32,
    // q - P(u), across the tangent.
    r: vec3f,
    // r . v_hat and r . w_hat; never divided by the radius here, which may be zero.
    vw_len: vec2f,
    radius: f32,
    u_hat: vec3f,
    v_hat: vec3f,
}

fn nowhere() -> Root {
    return Root(false, 0u, 0.0, vec3f(0.0), vec2f(0.0), 0.0, vec3f(0.0), vec3f(0.0));
}

fn root_t(root: Root) -> f32 {
    return f32(root.segment) + root.u;
}

fn cross_section(c: Curve, u_hat: vec3f) -> mat2x3f {
    if light.frame_up == 0u {
        return curve_rotation_minimizing(c, u_hat);
    }
    let w_hat = perpendicular_up(light.up, u_hat);
    return mat2x3f(cross(w_hat, u_hat), w_hat);
}

// The root at `u` of segment `i`, found where it lies in the tube: V^2 + W^2 <= R^2.
fn root_inside(i: u32, q: vec3f, u: f32) -> Root {
    let c = segments[i].curve;
    var root = nowhere();
    root.segment = i;
    root.u = u;
    root.r = curve_offset(c, q, u);
    root.u_hat = curve_u_hat(c, u);
    root.radius = curve_radius(c, u);
    let across = cross_section(c, root.u_hat);
    root.v_hat = across[0];
    root.vw_len = root.r * across;
    root.found = root.radius >= 0.0 && dot(root.vw_len, root.vw_len) <= root.radius * root.radius;
    return root;
}

// f at the start of the first segment; the loop over segments carries f from joint to joint, one value for both sides.
fn first_joint(q: vec3f) -> f32 {
    return -dot(q - segments[0].curve.b0, segments[0].curve.d0);
}

fn end_joint(i: u32, q: vec3f) -> f32 {
    return -dot(q - segments[i].curve.b2, segments[i].curve.d1);
}

// The parameters to test on segment `i`, whose ends have the values f0 and f1; the extension, i = n, has one without end.
fn candidates(i: u32, q: vec3f, f0: f32, f1: f32) -> Roots {
    let c = segments[i].curve;
    if i == light.segment_count {
        let u = -f0 / (2.0 * dot(c.d0, c.d0));
        return Roots(u, 0.0, u > 0.0, false);
    }
    if curve_box_contains(c, q) {
        return increasing_roots(c, q, f0, f1);
    }
    return Roots(0.0, 0.0, false, false);
}

// Whether `a` has the smaller |r| / R, asked without dividing.
fn nearer(a: Root, b: Root) -> bool {
    return dot(a.r, a.r) * b.radius * b.radius < dot(b.r, b.r) * a.radius * a.radius;
}

// The root that counts. At a joint the same root comes from both sides with the same |r| / R, and the lower segment's came first; rounding may
// prefer the other side, by less than rounding.
fn nearest_root(q: vec3f) -> Root {
    var best = nowhere();
    var f0 = first_joint(q);
    for (var i = 0u; i < light.segment_count + light.extended; i++) {
        let f1 = end_joint(i, q);
        let roots = candidates(i, q, f0, f1);
        if roots.has_left {
            let root = root_inside(i, q, roots.left);
            if root.found && (!best.found || nearer(root, best)) {
                best = root;
            }
        }
        if roots.has_right {
            let root = root_inside(i, q, roots.right);
            if root.found && (!best.found || nearer(root, best)) {
                best = root;
            }
        }
        f0 = f1;
    }
    return best;
}

// tau, the rotation of the "up" frame about the tangent per unit of u.
fn twist(root: Root, u_hat_derivative: vec3f) -> f32 {
    if light.frame_up == 0u {
        return 0.0;
    }
    let along = dot(light.up, root.u_hat);
    let perp = max(length(light.up - root.u_hat * along), 1e-6);
    return along * dot(u_hat_derivative, root.v_hat) / perp;
}

// Unit direction in tube space from the surface to where its light comes from.
fn direction_at(root: Root) -> vec3f {
    let c = segments[root.segment].curve;
    let spread = root.r * curve_radius_derivative(c, root.u);
    var tangent = curve_d(c, root.u) * (2.0 * root.radius) + spread;
    if light.direction_path != 0u {
        let turn = curve_u_hat_derivative(c, root.u, root.u_hat);
        let speed = 2.0 * length(curve_d(c, root.u));
        tangent = root.u_hat * ((speed - dot(root.r, turn)) * root.radius) + spread
            + cross(root.u_hat, root.r) * (twist(root, turn) * root.radius);
    }
    let len = length(tangent);
    if len < DIRECTION_FLOOR {
        return -root.u_hat;
    }
    return -tangent / len;
}

fn profile(rho2: f32) -> f32 {
    if light.inv_cos_range == 0.0 {
        return 1.0;
    }
    let cos_theta = inverseSqrt(1.0 + rho2 * light.tan2_outer);
    let s = saturate((cos_theta - light.cos_outer) * light.inv_cos_range);
    return s * s * (3.0 - 2.0 * s);
}

// Abscissae and weights of bendy::GAUSS_LEGENDRE.
const GAUSS_LEGENDRE = array<vec2f, 4>(
    vec2f(0.18343464, 0.36268378),
    vec2f(0.5255324, 0.31370665),
    vec2f(0.7966665, 0.22238103),
    vec2f(0.96028986, 0.10122854),
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

// Arc length of the centre curve from the segment's start to u.
fn arc_length(c: Curve, u: f32) -> f32 {
    let aa = dot(c.a, c.a);
    let valley = -dot(c.d0, c.a);
    if valley > 0.0 && valley < u * aa {
        let split = valley / aa;
        return arc_quadrature(c, 0.0, split) + arc_quadrature(c, split, u);
    }
    return arc_quadrature(c, 0.0, u);
}

fn decay_at(root: Root) -> f32 {
    if light.decay == DECAY_NONE {
        return 1.0;
    }
    let along = segments[root.segment].arc_start + arc_length(segments[root.segment].curve, root.u);
    let s2 = max(along * along + dot(root.r, root.r), 1e-12) * light.world_per_tube * light.world_per_tube;
    return select(1.0 / s2, inverseSqrt(s2), light.decay == DECAY_LINEAR);
}

// Irradiance on a surface square to the light, without visibility.
fn irradiance(root: Root) -> vec3f {
    let s = segments[root.segment];
    let u = root.u;
    let w = 1.0 - u;
    let color = s.color_0 * (w * w) + s.color_1 * (2.0 * w * u) + s.color_2 * (u * u);
    let intensity = s.intensity_0 * (w * w) + s.intensity_1 * (2.0 * w * u) + s.intensity_2 * (u * u);
    var rho2 = 0.0;
    if root.radius > 0.0 {
        rho2 = dot(root.r, root.r) / (root.radius * root.radius);
    }
    return max(color, vec3f(0.0)) * (max(intensity, 0.0) * profile(rho2) * decay_at(root));
}

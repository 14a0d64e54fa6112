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
    world_per_tube: f32,
    // The shadow map's depth is (t - map_t_base) / map_t_span; nothing casts shadows beyond map_t_last.
    map_t_base: f32,
    map_t_span: f32,
    map_t_last: f32,
    // Radius over the depth of the map's cube; 1 where the map is even in v and w.
    slope: f32,
    // Texels a side of each face.
    shadow_resolution: f32,
    shadow_tolerance_texels: f32,
    tan2_outer: f32,
    cos_outer: f32,
    inv_cos_range: f32,
    // How far what casts shadows may stray from the surface, in tube space.
    mesh_error: f32,
    // These segments are a part of the light: its own t is t_start + t_span t.
    t_start: f32,
    t_span: f32,
    // Square of the distance within which light falls off no further, in tube space.
    least_distance2: f32,
    // See fit_of.
    fits: array<vec4f, 5>,
}

// What does not change while a light is bent is compiled into the shader: a software driver runs both sides
// of a branch, and gathers from an index that it does not know. What does change decides no branch and ends
// no loop by itself: that driver would compile the shader anew for each value. The constants come before this
// file:
//   BAKED_SEGMENTS  u32   segments to visit in straight code, the extension not counted; 0 for as many as the
// light has, in a loop
//   EXTENDED        bool  the light goes on past its last control point
//   FRAME_UP        bool  the frame is oriented by `up`, else rotation-minimising
//   DIRECTION_PATH  bool  light arrives along the path, else along the tube
//   DECAY           u32   one of the DECAY_ constants

@group(2) @binding(0) var<uniform> light: BendyLight;
// Uniform rather than storage: far faster on a software driver, and light::MAX_SEGMENTS and the extension fit
// into the size that all have.
@group(2) @binding(1) var<uniform> segments: array<Segment, 257>;

const JOINT_MERGE = 1e-5;
const DIRECTION_FLOOR = 1e-18;
// Further than any point that is asked for.
const FAR = 1e30;
// Largest values that stay finite through decay and the BRDF.
const MAX_RADIANCE = 1e15;
const MAX_DECAY = 1e15;
const DECAY_NONE = 0u;
const DECAY_LINEAR = 1u;

// A root of f that lies in the tube.
struct Place {
    found: bool,
    segment: u32,
    u: f32,
    // |q - P(u)|^2.
    r2: f32,
    radius: f32,
}

struct Root {
    segment: u32,
    u: f32,
    // q - P(u), across the tangent.
    r: vec3f,
    // r . v_hat and r . w_hat; never divided by the radius here, which may be zero.
    vw_len: vec2f,
    radius: f32,
    u_hat: vec3f,
    v_hat: vec3f,
    // Half the derivatives of position, first and second.
    d: vec3f,
    a: vec3f,
    radius_derivative: f32,
    // Half the radius's second derivative.
    ar: f32,
    // Colour times intensity.
    radiance: vec3f,
    // Arc length of the centre curve from the source.
    travelled: f32,
}

fn root_t(root: Root) -> f32 {
    return f32(root.segment) + root.u;
}

// The root at `u` of segment `i`, found where it lies in the tube: |r| <= R.
fn place_at(i: u32, q: vec3f, u: f32) -> Place {
    let r = curve_offset(segments[i].curve, q, u);
    let radius = curve_radius(segments[i].curve, u);
    let r2 = dot(r, r);
    return Place(radius >= 0.0 && r2 <= radius * radius, i, u, r2, radius);
}

// Segment `i`, picked from all where their number is known: a software driver gathers one number after the
// other.
fn segment_at(i: u32) -> Segment {
    if BAKED_SEGMENTS == 0u {
        return segments[i];
    }
    var s = segments[0];
    if BAKED_SEGMENTS > 1u && i == 1u { s = segments[1]; }
    if BAKED_SEGMENTS > 2u && i == 2u { s = segments[2]; }
    if BAKED_SEGMENTS > 3u && i == 3u { s = segments[3]; }
    if BAKED_SEGMENTS > 4u && i == 4u { s = segments[4]; }
    if BAKED_SEGMENTS > 5u && i == 5u { s = segments[5]; }
    if EXTENDED && i == BAKED_SEGMENTS { s = segments[BAKED_SEGMENTS]; }
    return s;
}

// All that is known at a place.
fn root_at(place: Place, q: vec3f) -> Root {
    let s = segment_at(place.segment);
    let c = s.curve;
    let u = place.u;
    var root: Root;
    root.segment = place.segment;
    root.u = u;
    root.r = curve_offset(c, q, u);
    root.radius = place.radius;
    root.u_hat = curve_u_hat(c, u);
    let across = curve_cross_section(c, root.u_hat, FRAME_UP, light.up);
    root.v_hat = across[0];
    root.vw_len = root.r * across;
    root.d = curve_d(c, u);
    root.a = c.a;
    root.radius_derivative = curve_radius_derivative(c, u);
    root.ar = c.ar;
    root.radiance = source_radiance(s, u);
    if DECAY != DECAY_NONE {
        root.travelled = s.arc_start + arc_length(c, u);
    }
    return root;
}

// Colour times intensity, neither below zero.
fn source_radiance(s: Segment, u: f32) -> vec3f {
    let w = 1.0 - u;
    let basis = vec3f(w * w, 2.0 * w * u, u * u);
    let color = s.color_0 * basis.x + s.color_1 * basis.y + s.color_2 * basis.z;
    let intensity = s.intensity_0 * basis.x + s.intensity_1 * basis.y + s.intensity_2 * basis.z;
    return min(max(color, vec3f(0.0)) * max(intensity, 0.0), vec3f(MAX_RADIANCE));
}

// f at the start of the first segment; the loop over segments carries f from joint to joint, one value for
// both sides.
fn first_joint(q: vec3f) -> f32 {
    return -dot(q - segments[0].curve.b0, segments[0].curve.d0);
}

fn end_joint(i: u32, q: vec3f) -> f32 {
    return -dot(q - segments[i].curve.b2, segments[i].curve.d1);
}

// The parameters to test on segment `i`, whose ends have the values f0 and f1; the extension, i = n, has one
// without end.
fn candidates(i: u32, q: vec3f, f0: f32, f1: f32) -> Roots {
    let c = segments[i].curve;
    if EXTENDED && i == segment_count() {
        let u = -f0 / (2.0 * dot(c.d0, c.d0));
        return Roots(u, 0.0, u > 0.0, false);
    }
    if curve_box_contains(c, q) {
        return increasing_roots(c, q, f0, f1);
    }
    return Roots(0.0, 0.0, false, false);
}

// Whether `a` has the smaller |r| / R, asked without dividing.
fn nearer(a: Place, b: Place) -> bool {
    return a.r2 * b.radius * b.radius < b.r2 * a.radius * a.radius;
}

// Segments without the extension.
fn segment_count() -> u32 {
    return select(BAKED_SEGMENTS, light.segment_count, BAKED_SEGMENTS == 0u);
}

struct Search {
    best: Place,
    // f at the joint that comes next.
    f0: f32,
}

fn consider(search: ptr<function, Search>, i: u32, q: vec3f, u: f32) {
    let place = place_at(i, q, u);
    if place.found && (!(*search).best.found || nearer(place, (*search).best)) {
        (*search).best = place;
    }
}

fn visit(search: ptr<function, Search>, i: u32, q: vec3f) {
    let f1 = end_joint(i, q);
    let roots = candidates(i, q, (*search).f0, f1);
    if roots.has_left {
        consider(search, i, q, roots.left);
    }
    if roots.has_right {
        consider(search, i, q, roots.right);
    }
    (*search).f0 = f1;
}

// The place that counts: the one with the smallest |r| / R. At a joint the same root comes from both sides,
// equal but for rounding; either will do.
fn nearest_place(q: vec3f) -> Place {
    var search = Search(Place(), first_joint(q));
    if BAKED_SEGMENTS == 0u {
        // Always all of them; see above.
        let end = select(0u, light.segment_count, abs(q.x) < FAR);
        for (var i = 0u; i < end; i++) {
            visit(&search, i, q);
        }
    }
    if BAKED_SEGMENTS > 0u { visit(&search, 0u, q); }
    if BAKED_SEGMENTS > 1u { visit(&search, 1u, q); }
    if BAKED_SEGMENTS > 2u { visit(&search, 2u, q); }
    if BAKED_SEGMENTS > 3u { visit(&search, 3u, q); }
    if BAKED_SEGMENTS > 4u { visit(&search, 4u, q); }
    if BAKED_SEGMENTS > 5u { visit(&search, 5u, q); }
    if EXTENDED {
        visit(&search, segment_count(), q);
    }
    return search.best;
}

// tau, the rotation of the "up" frame about the tangent per unit of u.
fn twist(root: Root, u_hat_derivative: vec3f) -> f32 {
    if !FRAME_UP {
        return 0.0;
    }
    let along = dot(light.up, root.u_hat);
    let perp = max(length(light.up - root.u_hat * along), 1e-6);
    return along * dot(u_hat_derivative, root.v_hat) / perp;
}

// Derivative of the unit tangent.
fn turn_at(root: Root) -> vec3f {
    let speed = length(root.d);
    if speed > 0.0 {
        return (root.a - root.u_hat * dot(root.a, root.u_hat)) / speed;
    }
    return vec3f(0.0);
}

// Unit direction in tube space from the surface to where its light comes from.
fn direction_at(root: Root) -> vec3f {
    let spread = root.r * root.radius_derivative;
    var tangent = root.d * (2.0 * root.radius) + spread;
    if DIRECTION_PATH {
        let turn = turn_at(root);
        tangent = root.u_hat * ((2.0 * length(root.d) - dot(root.r, turn)) * root.radius) + spread
            + cross(root.u_hat, root.r) * (twist(root, turn) * root.radius);
    }
    let len = length(tangent);
    if len < DIRECTION_FLOOR {
        return -root.u_hat;
    }
    return -tangent / len;
}

fn profile(rho2: f32) -> f32 {
    let cos_theta = inverseSqrt(1.0 + rho2 * light.tan2_outer);
    let s = saturate((cos_theta - light.cos_outer) * light.inv_cos_range);
    return select(s * s * (3.0 - 2.0 * s), 1.0, light.inv_cos_range == 0.0);
}

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
    if DECAY == DECAY_NONE {
        return 1.0;
    }
    let in_tube = max(root.travelled * root.travelled + dot(root.r, root.r), light.least_distance2);
    let s2 = in_tube * light.world_per_tube * light.world_per_tube;
    if DECAY == DECAY_LINEAR {
        return min(inverseSqrt(max(s2, 1e-30)), MAX_DECAY);
    }
    return min(1.0 / max(s2, 1e-30), MAX_DECAY);
}

// Irradiance on a surface square to the light, without visibility.
fn irradiance(root: Root) -> vec3f {
    var rho2 = 0.0;
    if root.radius > 0.0 {
        rho2 = dot(root.r, root.r) / (root.radius * root.radius);
    }
    return root.radiance * (profile(rho2) * decay_at(root));
}

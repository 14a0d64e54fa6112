// A BendyLight and the coordinates of a point in it; twin of `light`'s tube.rs. Follows curve.wgsl, frame.wgsl,
// solve.wgsl, arc.wgsl, segment.wgsl and profile.wgsl. Positions `q` are in tube space; the caller transforms them with
// a matrix composed in f64.

struct BendyLight {
    // Columns; the translation is in the last one.
    tube_from_scene: mat4x4f,
    // Rotation only.
    world_from_tube: mat3x3f,
    up: vec3f,
    // Number of quadratic segments; one more follows if the light is extended.
    segment_count: u32,
    world_per_tube: f32,
    // The shadow map's depth is (t - map_t_base) / map_t_span; there are no casters beyond map_t_last.
    map_t_base: f32,
    map_t_span: f32,
    map_t_last: f32,
    // Radius divided by the depth of the map's cube; 1 if the map is uniform in v and w.
    slope: f32,
    // Texels a side of each face.
    shadow_resolution: f32,
    shadow_tolerance_texels: f32,
    // Largest distance of casters from the surface, in tube space.
    mesh_error: f32,
    // These segments are a part of the light, whose own t is t_start + t_span t.
    t_start: f32,
    t_span: f32,
    light_profile: LightProfile,
    // See fit_of.
    fits: array<vec4f, 5>,
}

// Values that do not change while a light is bent are compiled into the shader: a software driver runs both sides of a
// branch, and gathers from an index that it does not know. Values that change decide no branch and end no loop by
// themselves: that driver would compile the shader again for each value. The constants precede this file:
//   BAKED_SEGMENTS  u32   segments to visit without a loop, the extension not counted; 0 to loop over all of them
//   EXTENDED        bool  the light continues past its last control point
//   FRAME_UP        bool  the frame is oriented by `up`, else rotation-minimizing
//   DIRECTION_PATH  bool  light arrives along the path, else along the tube
//   PATH_LENGTH     bool  the light falls off with the length of its path

@group(2) @binding(0) var<uniform> light: BendyLight;
// A uniform, not storage: far faster on a software driver, and light::MAX_SEGMENTS and the extension fit into the size
// that all devices have.
@group(2) @binding(1) var<uniform> segments: array<Segment, 257>;

const JOINT_MERGE = 1e-5;
const DIRECTION_FLOOR = 1e-18;
// Farther than any point that is evaluated.
const FAR = 1e30;

// A root inside the tube, before its frame is known, for the search of the nearest.
struct RootInTube {
    found: bool,
    segment: u32,
    u: f32,
    // |q - P(u)|^2.
    r2: f32,
    radius: f32,
}

struct TubeRoot {
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
    // Color times intensity.
    emission: vec3f,
    // Length of the path from the source, in world units; 0 if nothing needs it.
    s: f32,
}

fn tube_root_t(root: TubeRoot) -> f32 {
    return f32(root.segment) + root.u;
}

// Returns the root at `u` of segment `i`; `found` is true if it is in the tube: |r| <= R.
fn inside_at(i: u32, q: vec3f, u: f32) -> RootInTube {
    let r = curve_offset(segments[i].curve, q, u);
    let radius = curve_radius(segments[i].curve, u);
    let r2 = dot(r, r);
    return RootInTube(radius >= 0.0 && r2 <= radius * radius, i, u, r2, radius);
}

// Returns segment `i`. Selects it among all segments if their number is compiled in: a software driver gathers one
// number after another.
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

// Returns the length of the light path to a root, from the arc length along the curve and the offset from the curve.
fn path_length(s: Segment, u: f32, r: vec3f) -> f32 {
    let along = s.arc_start + arc_length(s.curve, u);
    return length(vec4f(along, r)) * light.world_per_tube;
}

// Computes all values of a root from its segment and u.
fn root_at(inside: RootInTube, q: vec3f) -> TubeRoot {
    let s = segment_at(inside.segment);
    let c = s.curve;
    let u = inside.u;
    var root: TubeRoot;
    root.segment = inside.segment;
    root.u = u;
    root.r = curve_offset(c, q, u);
    root.radius = inside.radius;
    root.u_hat = curve_u_hat(c, u);
    let across = cross_section(c, root.u_hat, FRAME_UP, light.up);
    root.v_hat = across[0];
    root.vw_len = root.r * across;
    root.d = curve_d(c, u);
    root.a = c.a;
    root.radius_derivative = curve_radius_derivative(c, u);
    root.ar = c.ar;
    root.emission = segment_emission(s, u);
    if PATH_LENGTH {
        root.s = path_length(s, u, root.r);
    }
    return root;
}

// Returns f at the start of the first segment. The loop over segments carries f from joint to joint, one value for both
// sides.
fn first_joint(q: vec3f) -> f32 {
    return -dot(q - segments[0].curve.b0, segments[0].curve.d0);
}

fn end_joint(i: u32, q: vec3f) -> f32 {
    return -dot(q - segments[i].curve.b2, segments[i].curve.d1);
}

// Returns the parameters to test on segment `i`, whose ends have the values f0 and f1; the extension, i = n, has no
// end.
fn candidates(i: u32, q: vec3f, f0: f32, f1: f32) -> Roots {
    let c = segments[i].curve;
    if EXTENDED && i == segment_count() {
        let u = -f0 / (2.0 * dot(c.d0, c.d0));
        return Roots(u, 0.0, u > 0.0, false);
    }
    if tube_box_contains(c, q) {
        return increasing_roots(c, q, f0, f1);
    }
    return Roots(0.0, 0.0, false, false);
}

// Returns true if `a` has the smaller |r| / R. Compares without division.
fn nearer(a: RootInTube, b: RootInTube) -> bool {
    return a.r2 * b.radius * b.radius < b.r2 * a.radius * a.radius;
}

// Returns the number of segments without the extension.
fn segment_count() -> u32 {
    return select(BAKED_SEGMENTS, light.segment_count, BAKED_SEGMENTS == 0u);
}

struct Search {
    best: RootInTube,
    // f at the next joint.
    f0: f32,
}

fn consider(search: ptr<function, Search>, i: u32, q: vec3f, u: f32) {
    let inside = inside_at(i, q, u);
    if inside.found && (!(*search).best.found || nearer(inside, (*search).best)) {
        (*search).best = inside;
    }
}

fn visit_segment(search: ptr<function, Search>, i: u32, q: vec3f) {
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

// Returns the root by which light arrives: the one with the smallest |r| / R. At a joint the same root comes from both
// sides, equal except for rounding; either will do.
fn nearest_inside(q: vec3f) -> RootInTube {
    var search = Search(RootInTube(), first_joint(q));
    if BAKED_SEGMENTS == 0u {
        // Always all of them; see above.
        let end = select(0u, light.segment_count, abs(q.x) < FAR);
        for (var i = 0u; i < end; i++) {
            visit_segment(&search, i, q);
        }
    }
    if BAKED_SEGMENTS > 0u { visit_segment(&search, 0u, q); }
    if BAKED_SEGMENTS > 1u { visit_segment(&search, 1u, q); }
    if BAKED_SEGMENTS > 2u { visit_segment(&search, 2u, q); }
    if BAKED_SEGMENTS > 3u { visit_segment(&search, 3u, q); }
    if BAKED_SEGMENTS > 4u { visit_segment(&search, 4u, q); }
    if BAKED_SEGMENTS > 5u { visit_segment(&search, 5u, q); }
    if EXTENDED {
        visit_segment(&search, segment_count(), q);
    }
    return search.best;
}

// Returns tau, the rotation of the "up" frame about the tangent per unit of u.
fn twist(root: TubeRoot, u_hat_derivative: vec3f) -> f32 {
    if !FRAME_UP {
        return 0.0;
    }
    let along = dot(light.up, root.u_hat);
    let perp = max(length(light.up - root.u_hat * along), 1e-6);
    return along * dot(u_hat_derivative, root.v_hat) / perp;
}

fn u_hat_derivative(root: TubeRoot) -> vec3f {
    return curve_u_hat_derivative(root.d, root.a, root.u_hat);
}

// Returns the unit direction in tube space from the surface towards the arriving light.
fn direction_at(root: TubeRoot) -> vec3f {
    let spread = root.r * root.radius_derivative;
    var tangent = root.d * (2.0 * root.radius) + spread;
    if DIRECTION_PATH {
        let turn = u_hat_derivative(root);
        tangent = root.u_hat * ((2.0 * length(root.d) - dot(root.r, turn)) * root.radius) + spread
            + cross(root.u_hat, root.r) * (twist(root, turn) * root.radius);
    }
    let len = length(tangent);
    if len < DIRECTION_FLOOR {
        return -root.u_hat;
    }
    return -tangent / len;
}

// Coordinates of a root, with its direction in world axes.
fn coords_at(root: TubeRoot) -> LightCoords {
    let vw = root.vw_len / select(1.0, root.radius, root.radius > 0.0);
    let t = light.t_start + light.t_span * tube_root_t(root);
    return LightCoords(t, vw, root.s, normalize(light.world_from_tube * direction_at(root)));
}

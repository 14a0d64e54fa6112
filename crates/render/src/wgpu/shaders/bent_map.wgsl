// Maps world triangles into tube space, slab by slab. Follows curve.wgsl, frame.wgsl and solve.wgsl.
//
// A slab is a piece of the tube between two planes perpendicular to its curve. Inside the slab and its box the map is
// one to one. Slabs overlap a little, so that the image has no seams. A triangle is clipped in the scene, where its
// edges are straight, and then split until its edges are nearly straight in tube space, too.

struct Slab {
    curve: Curve,
    // n.q + w of the planes around the slab, ends first; zero or more inside.
    planes: array<vec4f, 6>,
    // Bounds of the bend of edges; see edge_is_safe.
    edge_bounds: vec4f,
}

struct BentMap {
    // Columns; the translation is in the last one.
    tube_from_scene: mat4x4f,
    up: vec3f,
    frame_up: u32,
    // Bounds of all slabs.
    box_min: vec3f,
    slab_count: u32,
    box_max: vec3f,
    vertex_count: u32,
    // Workgroups of pass 1.
    block_count: u32,
    face_count: u32,
    work_capacity: u32,
    patch_capacity: u32,
    split_capacity: u32,
    // Largest distance, in texels, between an edge's image and the straight line drawn for it.
    tolerance_texels: f32,
    // At the finest texels.
    texels_per_vw: f32,
    // Radius divided by the depth of the map's cube; 0 without a cube.
    cube_slope: f32,
    // Triangles from this one on are alpha-tested.
    opaque_triangles: u32,
    masked_capacity: u32,
    // Clip positions (X, Y, Z) on each face from (V, W, R).
    faces: array<mat3x3f, 5>,
}

@group(0) @binding(0) var<uniform> bent: BentMap;
// Capacity of a uniform of 64 KiB.
@group(0) @binding(1) var<uniform> slabs: array<Slab, 240>;

// A triangle in a slab: corners in tube space and mapped.
struct Patch {
    a: vec3f,
    slab: u32,
    b: vec3f,
    // Index among the alpha-tested triangles, or the kind of component: one of the constants below.
    caster: u32,
    c: vec3f,
    mapped_a: vec4f,
    mapped_b: vec4f,
    mapped_c: vec4f,
}

// A triangle and a slab that it may touch.
struct ToClip {
    triangle: u32,
    slab: u32,
    // Same meaning as in Patch.
    caster: u32,
}

// Kinds of components without an alpha test, counted down as `TriangleComponent` in Rust counts up. Light hits only the
// side of a closed component that faces it.
const OPEN = 0xffffffffu;
const CLOSED = 0xfffffffeu;
const INSIDE_OUT = 0xfffffffdu;

fn is_masked(caster: u32) -> bool {
    return caster < INSIDE_OUT;
}

fn caster_of(triangle: u32, shell: u32) -> u32 {
    return select(OPEN - shell, triangle - bent.opaque_triangles, triangle >= bent.opaque_triangles);
}

// Rasterization may move corners by this many of the finest texels: to a grid of 1/16 texel, the coarsest that Vulkan
// permits, with texels up to four times as wide along the other axis.
const SNAP_TEXELS = 0.25;

// Returns true if light hits the triangle from inside its component, so another triangle of the component is in front
// of it; false if moving its corners could turn it around.
fn faces_away(caster: u32, a: vec4f, b: vec4f, c: vec4f) -> bool {
    if is_masked(caster) || caster == OPEN || min(a.z, min(b.z, c.z)) <= 0.0 {
        return false;
    }
    let origin = a.xy / a.z;
    let ab = b.xy / b.z - origin;
    let ac = c.xy / c.z - origin;
    // Seen along the light, v to w turns clockwise. So a triangle that turns from v to w no longer shows its front to
    // the source.
    let area = select(-1.0, 1.0, caster == INSIDE_OUT) * (ab.x * ac.y - ab.y * ac.x);
    let round = (length(ab) + length(ac) + length(ac - ab)) * SNAP_TEXELS / texels_at(origin);
    return area < -round;
}

struct BentCounts {
    // Arguments of the indexed draw of triangles used as they are.
    whole_index_count: atomic<u32>,
    whole_instance_count: u32,
    whole_first_index: u32,
    whole_base_vertex: u32,
    whole_first_instance: u32,
    // Arguments of the draw of clipped and split triangles.
    split_vertex_count: atomic<u32>,
    split_instance_count: u32,
    split_first_vertex: u32,
    split_first_instance: u32,
    // Arguments of the draw of alpha-tested triangles.
    masked_vertex_count: atomic<u32>,
    masked_instance_count: u32,
    masked_first_vertex: u32,
    masked_first_instance: u32,
    // Index in `items` of the running pass's input; its output goes to the next.
    level: u32,
    // (triangle, slab) pairs, then patches level by level.
    items: array<atomic<u32>, 12>,
}

fn tube_position(x: f32, y: f32, z: f32) -> vec3f {
    return (bent.tube_from_scene * vec4f(x, y, z, 1.0)).xyz;
}

// Returns the signed distance of a point from one of the planes around a slab. A point is inside if all six are zero or
// more.
fn slab_plane(slab: u32, plane: u32, q: vec3f) -> f32 {
    let p = slabs[slab].planes[plane];
    return dot(p.xyz, q) + p.w;
}

// Returns (V, W, R, t) of a point of the slab. The signs of the slope at the slab's ends are known, so rounding at a
// clipping plane does not lose the root.
fn map_to_slab(c: Curve, q: vec3f) -> vec4f {
    let f0 = min(-dot(q - c.b0, c.d0), 0.0);
    let f1 = max(-dot(q - c.b2, c.d1), 0.0);
    let roots = increasing_roots(c, q, f0, f1);
    var u = select(f0 / min(f0 - f1, -1e-30), roots.right, roots.has_right);
    u = select(u, roots.left, roots.has_left);
    if roots.has_left && roots.has_right
        && length(curve_offset(c, q, roots.right)) < length(curve_offset(c, q, roots.left)) {
        u = roots.right;
    }
    let across = cross_section(c, curve_u_hat(c, u), bent.frame_up != 0u, bent.up);
    let vw = curve_offset(c, q, u) * across;
    return vec4f(vw, max(curve_radius(c, u), 0.0), c.t_start + c.t_span * u);
}

// Returns true if the slab's bend does not show in the edge, which is short or nearly perpendicular to the light. See
// slab.rs for the derivation.
fn edge_is_safe(slab: u32, qa: vec3f, a: vec4f, qb: vec3f, b: vec4f) -> bool {
    let dt = abs(b.w - a.w);
    let bends = slabs[slab].edge_bounds * vec4f(dt, length(qb - qa), dt, length(qb - qa));
    return (bends.x + bends.y) * dt <= min(a.z, b.z) && bends.z + bends.w <= 1.0;
}

// Returns the number of texels per unit of v and w at a point. On a cube they are uniform in slope, so there are fewer
// per unit far off its axis.
fn texels_at(vw: vec2f) -> f32 {
    return bent.texels_per_vw / max(1.0, bent.cube_slope * max(abs(vw.x), abs(vw.y)));
}

// Returns true if a triangle's image is beyond one side of the drawn part of each face. `bow` is the largest deviation
// of (V, W, R) from the straight edges, as a length in tube space. A quadratic triangle deviates between its edges by
// at most 4/3 of the deviation at the middles of its edges; twice that leaves a margin.
fn off_map(a: vec4f, b: vec4f, c: vec4f, bow: f32) -> bool {
    var off = true;
    // The bound depends on more than uniforms: see branches.rs. A radius is never negative.
    let end = select(bent.face_count, 0u, a.z < 0.0);
    for (var face = 0u; face < end; face++) {
        off = off && off_face(bent.faces[face], a.xyz, b.xyz, c.xyz, 2.0 * bow);
    }
    return off;
}

fn off_face(clip_from_mapped: mat3x3f, a: vec3f, b: vec3f, c: vec3f, bow: f32) -> bool {
    let clip_a = clip_from_mapped * a;
    let clip_b = clip_from_mapped * b;
    let clip_c = clip_from_mapped * c;
    let margin = bow * (abs(clip_from_mapped[0]) + abs(clip_from_mapped[1]) + abs(clip_from_mapped[2]));
    let x = vec3f(clip_a.x, clip_b.x, clip_c.x);
    let y = vec3f(clip_a.y, clip_b.y, clip_c.y);
    let outer = vec3f(clip_a.z, clip_b.z, clip_c.z) + margin.z;
    let outer_x = outer + margin.x;
    let outer_y = outer + margin.y;
    return all(x > outer_x) || all(x < -outer_x) || all(y > outer_y) || all(y < -outer_y) || all(outer < vec3f(0.0));
}

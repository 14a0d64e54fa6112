// World triangles into tube space, slab by slab. Follows curve.wgsl, frame.wgsl and solve.wgsl.
//
// A slab is a piece of the tube between two planes square to its curve; inside it and its box the map is one
// to one. Slabs overlap a little, so that what is mapped slab by slab has no seams. A triangle is clipped in
// the scene, where its edges are straight, and then split until its edges are as good as straight in tube
// space too.

struct Slab {
    curve: Curve,
    // n.q + w of the planes around the slab, ends first; zero or more inside.
    planes: array<vec4f, 6>,
    // An edge shorter than this many texels is straight enough whatever its direction.
    safe_texels: f32,
}

struct BentMap {
    // Columns; the translation is in the last one.
    tube_from_scene: mat4x4f,
    up: vec3f,
    frame_up: u32,
    // Around all slabs.
    box_min: vec3f,
    slab_count: u32,
    box_max: vec3f,
    vertex_count: u32,
    triangle_count: u32,
    face_count: u32,
    work_capacity: u32,
    patch_capacity: u32,
    split_capacity: u32,
    // Largest distance, in texels, between an edge's image and the straight line drawn for it.
    tolerance_texels: f32,
    // Where they are finest.
    texels_per_vw: f32,
    // Radius over the depth of the map's cube; 0 where there is none.
    cube_slope: f32,
    // Triangles from this one on have an alpha test.
    opaque_triangles: u32,
    masked_capacity: u32,
    // Clip positions (X, Y, Z) on each face from (V, W, R).
    faces: array<mat3x3f, 5>,
}

@group(0) @binding(0) var<uniform> bent: BentMap;
// As many as a uniform of 64 KiB holds.
@group(0) @binding(1) var<uniform> slabs: array<Slab, 240>;

// A triangle in a slab: corners in tube space and mapped.
struct Patch {
    a: vec3f,
    slab: u32,
    b: vec3f,
    // Which triangle of those with an alpha test it is of, or `NOT_MASKED`.
    masked: u32,
    c: vec3f,
    mapped_a: vec4f,
    mapped_b: vec4f,
    mapped_c: vec4f,
}

const NOT_MASKED = 0xffffffffu;

fn masked_triangle(triangle: u32) -> u32 {
    return select(NOT_MASKED, triangle - bent.opaque_triangles, triangle >= bent.opaque_triangles);
}

struct BentCounts {
    // Arguments of the indexed draw: triangles used as they are.
    whole_index_count: atomic<u32>,
    whole_instance_count: u32,
    whole_first_index: u32,
    whole_base_vertex: u32,
    whole_first_instance: u32,
    // Arguments of the draw of what was clipped and split.
    split_vertex_count: atomic<u32>,
    split_instance_count: u32,
    split_first_vertex: u32,
    split_first_instance: u32,
    // Arguments of the draw of those with an alpha test.
    masked_vertex_count: atomic<u32>,
    masked_instance_count: u32,
    masked_first_vertex: u32,
    masked_first_instance: u32,
    // Which of `items` the running pass reads; it appends to the next.
    level: u32,
    // (triangle, slab) pairs, then patches level by level.
    items: array<atomic<u32>, 12>,
}

fn tube_position(x: f32, y: f32, z: f32) -> vec3f {
    return (bent.tube_from_scene * vec4f(x, y, z, 1.0)).xyz;
}

// Signed distance from one of the planes around a slab; inside where all six are zero or more.
fn slab_plane(slab: u32, plane: u32, q: vec3f) -> f32 {
    let p = slabs[slab].planes[plane];
    return dot(p.xyz, q) + p.w;
}

// (V, W, R, t) of a point of the slab. The signs at the ends are known; rounding at a clipping plane must not
// lose the root.
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

// Whether the edge between two mapped points needs a point between, and that point.
struct Middle {
    split: bool,
    // How far (V, W, R) strays from the straight edge, as a length in tube space; 0 where too little to see.
    bow: f32,
    q: vec3f,
    mapped: vec4f,
}

// Four roundings of a position of size 1, the length of the light.
const POSITION_ROUNDING = 0x1p-22;

// Compares the image of the edge's middle with the middle of the images, and so the quarters: an S crosses its
// chord in the middle. The middle of homogeneous (V, W, R) is what the rasteriser draws; on a straight cone both
// agree.
fn edge_middle(slab: u32, qa: vec3f, a: vec4f, qb: vec3f, b: vec4f) -> Middle {
    var middle = Middle(false, 0.0, (qa + qb) * 0.5, vec4f(0.0));
    if edge_is_safe(slab, qa, a, qb, b) {
        return middle;
    }
    let c = slabs[slab].curve;
    middle.mapped = map_to_slab(c, middle.q);
    let straight = (a + b) * 0.5;
    // Made from both ends alike, so that the edge's other triangle finds the same bits.
    let near_a = (qa + middle.q) * 0.5;
    let near_b = (qb + middle.q) * 0.5;
    let mapped_a = map_to_slab(c, near_a);
    let mapped_b = map_to_slab(c, near_b);
    let straight_a = (a + straight) * 0.5;
    let straight_b = (b + straight) * 0.5;
    middle.split = strays(c, middle.q, middle.mapped, straight) || strays(c, near_a, mapped_a, straight_a)
        || strays(c, near_b, mapped_b, straight_b);
    middle.bow = max(bow(middle.mapped, straight), max(bow(mapped_a, straight_a), bow(mapped_b, straight_b)));
    return middle;
}

fn bow(mapped: vec4f, straight: vec4f) -> f32 {
    return length(mapped.xy - straight.xy) + abs(mapped.z - straight.z);
}

// Whether a triangle's image lies beyond one side of what is drawn of each face. Between its edges it strays by at most
// 4/3 of what the middles of its edges do, were it quadratic: twice leaves room for more.
fn off_map(a: vec4f, b: vec4f, c: vec4f, ab: Middle, bc: Middle, ca: Middle) -> bool {
    let bow = 2.0 * max(ab.bow, max(bc.bow, ca.bow));
    var off = true;
    // No bound of uniforms alone: see branches.rs.
    let end = select(bent.face_count, 0u, bow < 0.0);
    for (var face = 0u; face < end; face++) {
        off = off && off_face(bent.faces[face], a.xyz, b.xyz, c.xyz, bow);
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

// Texels per unit of v and w at a point. On a cube they are as wide as angles, so fewer far off its axis.
fn texels_at(vw: vec2f) -> f32 {
    return bent.texels_per_vw / max(1.0, bent.cube_slope * max(abs(vw.x), abs(vw.y)));
}

// How much faster than the centre a path at (v, w) runs on a cube; 1 else. The twin of map_speed in bendy.wgsl.
fn stretch_at(c: Curve, vw: vec2f) -> f32 {
    let spread = curve_radius_derivative(c, 0.5) * min(length(vw), 1.5) / max(2.0 * length(curve_d(c, 0.5)), 1e-20);
    return select(1.0, length(vec2f(1.0, spread)), bent.cube_slope > 0.0);
}

// Whether a point's image lies too far from where the straight edge has it, in texels: across the map, and along
// the light as the length it is in the scene.
fn strays(c: Curve, q: vec3f, mapped: vec4f, straight: vec4f) -> bool {
    if min(mapped.z, straight.z) <= 0.0 {
        return false;
    }
    let vw = straight.xy / straight.z;
    let scale = texels_at(vw);
    let stretch = stretch_at(c, vw);
    let across = (mapped.xy / mapped.z - vw) * scale;
    let along = (mapped.w - straight.w) / c.t_span * 2.0 * length(curve_d(c, 0.5)) * stretch * scale / straight.z;
    // In a very thin tube a texel is less than the rounding of a position: what bends there is noise, and splitting
    // for it would not end.
    let rounding = POSITION_ROUNDING * (1.0 + length(q)) * stretch * scale / straight.z;
    return max(length(across), abs(along)) > max(bent.tolerance_texels, rounding);
}

// Whether the edge is so short that no bend of this slab shows in it.
fn edge_is_safe(slab: u32, qa: vec3f, a: vec4f, qb: vec3f, b: vec4f) -> bool {
    return length(qb - qa) * bent.texels_per_vw <= slabs[slab].safe_texels * min(a.z, b.z);
}

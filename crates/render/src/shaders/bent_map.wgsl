// World triangles into tube space, slab by slab. Follows curve.wgsl.
//
// A slab is a piece of the tube between two planes square to its curve; inside it and its box the map is one to one. Slabs overlap a
// little, so that what is mapped slab by slab has no seams. A triangle is clipped in the scene, where its edges are straight, and then split until
// its edges are as good as straight in tube space too.

struct BentMap {
    // Columns; the translation is in the last one.
    tube_from_scene: mat4x4f,
    up: vec3f,
    frame_up: u32,
    slab_count: u32,
    vertex_count: u32,
    triangle_count: u32,
    shadow_resolution: f32,
    work_capacity: u32,
    patch_capacity: u32,
    split_capacity: u32,
    // Largest distance, in texels, between an edge's image and the straight line drawn for it.
    tolerance_texels: f32,
}

@group(0) @binding(0) var<uniform> bent: BentMap;
@group(0) @binding(1) var<storage, read> slabs: array<Curve>;

// A triangle in a slab: corners in tube space and mapped.
struct Patch {
    a: vec3f,
    slab: u32,
    b: vec3f,
    c: vec3f,
    mapped_a: vec4f,
    mapped_b: vec4f,
    mapped_c: vec4f,
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
    // Which of `items` the running pass reads; it appends to the next.
    stage: u32,
    // (triangle, slab) pairs, then patches level by level.
    items: array<atomic<u32>, 12>,
}

fn tube_position(positions_x: f32, positions_y: f32, positions_z: f32) -> vec3f {
    return (bent.tube_from_scene * vec4f(positions_x, positions_y, positions_z, 1.0)).xyz;
}

// Signed against the six planes around a slab; inside where all are zero or more.
fn slab_plane(c: Curve, plane: u32, q: vec3f) -> f32 {
    switch plane {
        case 0u: { return dot(q - c.b0, c.d0); }
        case 1u: { return dot(c.b2 - q, c.d1); }
        case 2u: { return c.box_half_1 - dot(q - c.box_center, c.box_axis_1); }
        case 3u: { return c.box_half_1 + dot(q - c.box_center, c.box_axis_1); }
        case 4u: { return c.box_half_2 - dot(q - c.box_center, c.box_axis_2); }
        default: { return c.box_half_2 + dot(q - c.box_center, c.box_axis_2); }
    }
}

fn slab_cross_section(c: Curve, u_hat: vec3f) -> mat2x3f {
    if bent.frame_up == 0u {
        return curve_rotation_minimizing(c, u_hat);
    }
    let w_hat = perpendicular_up(bent.up, u_hat);
    return mat2x3f(cross(w_hat, u_hat), w_hat);
}

// (V, W, R, t) of a point of the slab. The signs at the ends are known; rounding at a clipping plane must not lose the root.
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
    let vw = curve_offset(c, q, u) * slab_cross_section(c, curve_u_hat(c, u));
    return vec4f(vw, max(curve_radius(c, u), 0.0), c.t_start + c.t_span * u);
}

// Whether the edge between two mapped points needs a point between, and that point.
struct Middle {
    split: bool,
    q: vec3f,
    mapped: vec4f,
}

// Compares the image of the edge's middle with the middle of the images, in texels: across the map, and along the light as the length it is in
// the scene. The middle of homogeneous (V, W, R) is what the rasteriser draws; on a straight cone both agree.
fn edge_middle(c: Curve, qa: vec3f, a: vec4f, qb: vec3f, b: vec4f) -> Middle {
    var middle = Middle(false, (qa + qb) * 0.5, vec4f(0.0));
    let straight = (a + b) * 0.5;
    // Nothing shorter than four texels bends by a noticeable part of one.
    let span = abs(a.xy * b.z - b.xy * a.z);
    let scale = 0.5 * bent.shadow_resolution;
    let drawn = max(span.x, span.y) * scale > 4.0 * a.z * b.z;
    if straight.z <= 0.0 {
        return middle;
    }
    let length_texels = abs(a.w - b.w) / c.t_span * 2.0 * length(curve_d(c, 0.5)) * scale / straight.z;
    if !drawn && length_texels < 4.0 {
        return middle;
    }
    middle.mapped = map_to_slab(c, middle.q);
    if middle.mapped.z <= 0.0 {
        return middle;
    }
    let across = (middle.mapped.xy / middle.mapped.z - straight.xy / straight.z) * scale;
    let along = (middle.mapped.w - straight.w) / c.t_span * 2.0 * length(curve_d(c, 0.5)) * scale / straight.z;
    middle.split = max(length(across), abs(along)) > bent.tolerance_texels;
    return middle;
}

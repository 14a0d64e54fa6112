// Pass 4, level by level: drops a patch off the map, draws one with straight enough edges, and splits any other at the
// middles of its bent edges. The decision to split an edge depends on that edge alone, so adjacent patches agree and no
// cracks open. Follows bent_map.wgsl.

@group(0) @binding(2) var<storage, read> patches_in: array<Patch>;
@group(0) @binding(3) var<storage, read_write> patches_out: array<Patch>;
@group(0) @binding(4) var<storage, read_write> counts: BentCounts;
// (V, W, R, t), three per triangle.
@group(0) @binding(5) var<storage, read_write> split_vertices: array<vec4f>;
// (V, W, R, t) of alpha-tested triangles, three per triangle.
@group(0) @binding(6) var<storage, read_write> masked_vertices: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> masked_places: array<MaskedPlace>;

// Position of a vertex in its triangle.
struct MaskedPlace {
    q: vec3f,
    // Index among the alpha-tested triangles.
    triangle: u32,
}

// Last entry of `items` that takes patches; patches there are drawn as they are.
const LAST_LEVEL = 11u;

// Middle of the edge between two mapped points, and true if the edge must be split there.
struct Middle {
    split: bool,
    // Deviation of (V, W, R) from the straight edge, as a length in tube space; 0 if too small to matter.
    bow: f32,
    q: vec3f,
    mapped: vec4f,
}

// Four roundings of a position of size 1, the length of the light.
const POSITION_ROUNDING = 0x1p-22;

// Compares the image of the edge's middle with the middle of the images, and the quarters likewise, because an S-shaped
// image crosses its chord in the middle. The rasterizer draws the middle of homogeneous (V, W, R); on a straight cone
// both agree.
fn edge_middle(slab: u32, qa: vec3f, a: vec4f, qb: vec3f, b: vec4f) -> Middle {
    var middle = Middle(false, 0.0, (qa + qb) * 0.5, vec4f(0.0));
    if edge_is_safe(slab, qa, a, qb, b) {
        return middle;
    }
    let c = slabs[slab].curve;
    middle.mapped = map_to_slab(c, middle.q);
    let straight = (a + b) * 0.5;
    // Symmetric in both ends, so that the edge's other triangle gets the same bits.
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

// Returns the ratio of a path's speed at (v, w) to that of the center, on a cube; 1 otherwise. Twin of map_speed in
// bendy.wgsl.
fn stretch_at(c: Curve, vw: vec2f) -> f32 {
    let spread = curve_radius_derivative(c, 0.5) * min(length(vw), 1.5) / max(2.0 * length(curve_d(c, 0.5)), 1e-20);
    return select(1.0, length(vec2f(1.0, spread)), bent.cube_slope > 0.0);
}

// Returns true if a point's image is too far from the straight edge, in texels: across the map, and along the light as
// a length in the scene.
fn strays(c: Curve, q: vec3f, mapped: vec4f, straight: vec4f) -> bool {
    if min(mapped.z, straight.z) <= 0.0 {
        return false;
    }
    let vw = straight.xy / straight.z;
    let scale = texels_at(vw);
    let stretch = stretch_at(c, vw);
    let across = (mapped.xy / mapped.z - vw) * scale;
    let along = (mapped.w - straight.w) / c.t_span * 2.0 * length(curve_d(c, 0.5)) * stretch * scale / straight.z;
    // In a very thin tube a texel is smaller than the rounding of positions: the bend there is noise, and splitting
    // would not end.
    let rounding = POSITION_ROUNDING * (1.0 + length(q)) * stretch * scale / straight.z;
    return max(length(across), abs(along)) > max(bent.tolerance_texels, rounding);
}

fn draw(p: Patch) {
    if is_masked(p.caster) {
        draw_masked(p);
        return;
    }
    if faces_away(p.caster, p.mapped_a, p.mapped_b, p.mapped_c) {
        return;
    }
    let first = atomicAdd(&counts.split_vertex_count, 3u);
    if first + 3u <= bent.split_capacity {
        split_vertices[first] = p.mapped_a;
        split_vertices[first + 1u] = p.mapped_b;
        split_vertices[first + 2u] = p.mapped_c;
    }
}

fn draw_masked(p: Patch) {
    let first = atomicAdd(&counts.masked_vertex_count, 3u);
    if first + 3u <= bent.masked_capacity {
        masked_vertices[first] = p.mapped_a;
        masked_vertices[first + 1u] = p.mapped_b;
        masked_vertices[first + 2u] = p.mapped_c;
        masked_places[first] = MaskedPlace(p.a, p.caster);
        masked_places[first + 1u] = MaskedPlace(p.b, p.caster);
        masked_places[first + 2u] = MaskedPlace(p.c, p.caster);
    }
}

fn pass_on(slot: u32, parent: Patch, qa: vec3f, a: vec4f, qb: vec3f, b: vec4f, qc: vec3f, c: vec4f) {
    if slot < bent.patch_capacity {
        patches_out[slot] = Patch(qa, parent.slab, qb, parent.caster, qc, a, b, c);
    }
}

@compute @workgroup_size(64)
fn split_patches(@builtin(global_invocation_id) id: vec3u) {
    let level = counts.level;
    if id.x >= min(atomicLoad(&counts.items[level]), bent.patch_capacity) {
        return;
    }
    let p = patches_in[id.x];
    var ab = edge_middle(p.slab, p.a, p.mapped_a, p.b, p.mapped_b);
    var bc = edge_middle(p.slab, p.b, p.mapped_b, p.c, p.mapped_c);
    var ca = edge_middle(p.slab, p.c, p.mapped_c, p.a, p.mapped_a);
    if off_map(p.mapped_a, p.mapped_b, p.mapped_c, max(ab.bow, max(bc.bow, ca.bow))) {
        return;
    }
    let splits = u32(ab.split) + u32(bc.split) + u32(ca.split);
    if splits == 0u || level == LAST_LEVEL {
        draw(p);
        return;
    }
    let slot = atomicAdd(&counts.items[level + 1u], splits + 1u);
    if splits == 3u {
        pass_on(slot, p, p.a, p.mapped_a, ab.q, ab.mapped, ca.q, ca.mapped);
        pass_on(slot + 1u, p, p.b, p.mapped_b, bc.q, bc.mapped, ab.q, ab.mapped);
        pass_on(slot + 2u, p, p.c, p.mapped_c, ca.q, ca.mapped, bc.q, bc.mapped);
        pass_on(slot + 3u, p, ab.q, ab.mapped, bc.q, bc.mapped, ca.q, ca.mapped);
        return;
    }
    // Rotates the triangle until a split edge comes first and, of two, the second next.
    var qa = p.a; var qb = p.b; var qc = p.c;
    var ma = p.mapped_a; var mb = p.mapped_b; var mc = p.mapped_c;
    var first = ab;
    var second = bc;
    if bc.split && !ab.split {
        qa = p.b; qb = p.c; qc = p.a;
        ma = p.mapped_b; mb = p.mapped_c; mc = p.mapped_a;
        first = bc; second = ca;
    } else if ca.split && !bc.split {
        qa = p.c; qb = p.a; qc = p.b;
        ma = p.mapped_c; mb = p.mapped_a; mc = p.mapped_b;
        first = ca; second = ab;
    }
    if splits == 1u {
        pass_on(slot, p, qa, ma, first.q, first.mapped, qc, mc);
        pass_on(slot + 1u, p, first.q, first.mapped, qb, mb, qc, mc);
    } else {
        pass_on(slot, p, first.q, first.mapped, qb, mb, second.q, second.mapped);
        pass_on(slot + 1u, p, qa, ma, first.q, first.mapped, second.q, second.mapped);
        pass_on(slot + 2u, p, qa, ma, second.q, second.mapped, qc, mc);
    }
}

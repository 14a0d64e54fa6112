// Pass 4, level by level: a patch off the map is dropped, one whose edges are straight enough is drawn, any other is
// split at the middles of those that are not. Whether an edge is split depends on that edge alone, so neighbours
// agree and no cracks open. Follows bent_map.wgsl.

@group(0) @binding(2) var<storage, read> patches_in: array<Patch>;
@group(0) @binding(3) var<storage, read_write> patches_out: array<Patch>;
@group(0) @binding(4) var<storage, read_write> counts: BentCounts;
// (V, W, R, t), three a triangle.
@group(0) @binding(5) var<storage, read_write> split_vertices: array<vec4f>;
// The same of triangles with an alpha test.
@group(0) @binding(6) var<storage, read_write> masked_vertices: array<vec4f>;
@group(0) @binding(7) var<storage, read_write> masked_places: array<MaskedPlace>;

// Where a vertex lies in its triangle.
struct MaskedPlace {
    q: vec3f,
    // Among those with an alpha test.
    triangle: u32,
}

// The last entry of `items` that patches are appended to; patches there are drawn as they are.
const LAST_LEVEL = 11u;

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
    // Turn the triangle until a split edge comes first and, of two, the second next.
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

// Pass 2: processes every triangle near the slabs once. It is dropped, used as it is, passed on as a patch if it is in
// one slab and may be bent, or else listed with each slab that it may touch. Follows bent_map.wgsl.

@group(0) @binding(2) var<storage, read> positions: array<f32>;
@group(0) @binding(3) var<storage, read> mapped: array<vec4f>;
@group(0) @binding(4) var<storage, read> vertex_slab: array<u32>;
@group(0) @binding(5) var<storage, read> indices: array<u32>;
@group(0) @binding(6) var<storage, read_write> whole_indices: array<u32>;
@group(0) @binding(7) var<storage, read_write> work: array<ToClip>;
@group(0) @binding(8) var<storage, read_write> counts: BentCounts;
@group(0) @binding(9) var<storage, read_write> patches_out: array<Patch>;
// Entries of two workgroups per element: the first triangle, and the number of triangles with their component above 16
// bits.
@group(0) @binding(10) var<uniform> leaves: array<vec4u, 4096>;

fn vertex_position(vertex: u32) -> vec3f {
    return tube_position(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

// Returns true if the whole triangle is outside one of the slab's planes.
fn beyond(slab: u32, plane: u32, a: vec3f, b: vec3f, c: vec3f) -> bool {
    return max(max(slab_plane(slab, plane, a), slab_plane(slab, plane, b)), slab_plane(slab, plane, c)) < 0.0;
}

fn may_touch(slab: u32, a: vec3f, b: vec3f, c: vec3f) -> bool {
    return !(beyond(slab, 0u, a, b, c) || beyond(slab, 1u, a, b, c) || beyond(slab, 2u, a, b, c)
        || beyond(slab, 3u, a, b, c) || beyond(slab, 4u, a, b, c) || beyond(slab, 5u, a, b, c));
}

@compute @workgroup_size(64)
fn map_triangles(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) own: u32) {
    let two = leaves[group.x / 2u];
    let leaf = select(two.xy, two.zw, group.x % 2u == 1u);
    if own >= (leaf.y & 0xffffu) {
        return;
    }
    let triangle = leaf.x + own;
    let caster = caster_of(triangle, leaf.y >> 16u);
    let corners = vec3u(indices[3u * triangle], indices[3u * triangle + 1u], indices[3u * triangle + 2u]);
    let qa = vertex_position(corners.x);
    let qb = vertex_position(corners.y);
    let qc = vertex_position(corners.z);
    let slab = vertex_slab[corners.x];
    if slab < bent.slab_count && slab == vertex_slab[corners.y] && slab == vertex_slab[corners.z] {
        let a = mapped[corners.x];
        let b = mapped[corners.y];
        let c = mapped[corners.z];
        // Nearly all edges are. A closer test here would cost every triangle nine solves; pass 4 does it for the few.
        let safe = edge_is_safe(slab, qa, a, qb, b) && edge_is_safe(slab, qb, b, qc, c)
            && edge_is_safe(slab, qc, c, qa, a);
        if safe && (off_map(a, b, c, 0.0) || faces_away(caster, a, b, c)) {
            return;
        }
        // A patch knows its triangle, which the alpha test needs.
        if !safe || is_masked(caster) {
            let item = atomicAdd(&counts.items[1], 1u);
            if item < bent.patch_capacity {
                patches_out[item] = Patch(qa, slab, qb, caster, qc, a, b, c);
            }
            return;
        }
        let first = atomicAdd(&counts.whole_index_count, 3u);
        whole_indices[first] = corners.x;
        whole_indices[first + 1u] = corners.y;
        whole_indices[first + 2u] = corners.z;
        return;
    }
    let near = all(max(max(qa, qb), qc) >= bent.box_min) && all(min(min(qa, qb), qc) <= bent.box_max);
    let end = select(0u, bent.slab_count, near);
    for (var i = 0u; i < end; i++) {
        if may_touch(i, qa, qb, qc) {
            let item = atomicAdd(&counts.items[0], 1u);
            if item < bent.work_capacity {
                work[item] = ToClip(triangle, i, caster);
            }
        }
    }
}

// Pass 1: maps every vertex of the blocks near the slabs once. Follows bent_map.wgsl.

@group(0) @binding(2) var<storage, read> positions: array<f32>;
// (V, W, R, t) in the first slab that contains the vertex.
@group(0) @binding(3) var<storage, read_write> mapped: array<vec4f>;
// Index of that slab, or one of the two constants below.
@group(0) @binding(4) var<storage, read_write> vertex_slab: array<u32>;

// One per workgroup.
@group(0) @binding(5) var<storage, read> blocks: array<u32>;

const NO_SLAB = 0xffffffffu;
// In slabs of distant parts of the tube that overlap here.
const SEVERAL_SLABS = 0xfffffffeu;

fn slab_holds(slab: u32, q: vec3f) -> bool {
    let ends = min(slab_plane(slab, 0u, q), slab_plane(slab, 1u, q));
    let across = min(slab_plane(slab, 2u, q), slab_plane(slab, 3u, q));
    let along_normal = min(slab_plane(slab, 4u, q), slab_plane(slab, 5u, q));
    return min(ends, min(across, along_normal)) >= 0.0;
}

@compute @workgroup_size(64)
fn map_vertices(
    @builtin(workgroup_id) group: vec3u, @builtin(num_workgroups) groups: vec3u, @builtin(local_invocation_index) own: u32
) {
    let index = group.x + group.y * groups.x;
    if index >= bent.block_count {
        return;
    }
    let vertex = blocks[index] * 64u + own;
    if vertex >= bent.vertex_count {
        return;
    }
    let q = tube_position(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
    let near = all(q >= bent.box_min) && all(q <= bent.box_max);
    var slab = NO_SLAB;
    // The bound, not a branch, lets a group of far vertices finish at once on a software driver.
    let end = select(0u, bent.slab_count, near);
    for (var i = 0u; i < end && slab != SEVERAL_SLABS; i++) {
        if !slab_holds(i, q) {
            continue;
        }
        if slab == NO_SLAB {
            slab = i;
        } else if i > slab + 1u {
            // The next slab shares a margin with this one; any later one is another part of the tube.
            slab = SEVERAL_SLABS;
        }
    }
    vertex_slab[vertex] = slab;
    if slab < bent.slab_count {
        mapped[vertex] = map_to_slab(slabs[slab].curve, q);
    }
}

// Pass 1: every vertex once. Follows bent_map.wgsl.

@group(0) @binding(2) var<storage, read> positions: array<f32>;
// (V, W, R, t) in the first slab that holds the vertex.
@group(0) @binding(3) var<storage, read_write> mapped: array<vec4f>;
// That slab, or one of the two below.
@group(0) @binding(4) var<storage, read_write> vertex_slab: array<u32>;

const NO_SLAB = 0xffffffffu;
// In slabs of distant parts of the tube that overlap here.
const SEVERAL_SLABS = 0xfffffffeu;

fn slab_holds(c: Curve, q: vec3f) -> bool {
    for (var plane = 0u; plane < 6u; plane++) {
        if slab_plane(c, plane, q) < 0.0 {
            return false;
        }
    }
    return true;
}

@compute @workgroup_size(64)
fn map_vertices(@builtin(global_invocation_id) id: vec3u, @builtin(num_workgroups) groups: vec3u) {
    let vertex = id.x + id.y * groups.x * 64u;
    if vertex >= bent.vertex_count {
        return;
    }
    let q = tube_position(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
    var slab = NO_SLAB;
    for (var i = 0u; i < bent.slab_count; i++) {
        if !slab_holds(slabs[i], q) {
            continue;
        }
        if slab == NO_SLAB {
            slab = i;
        } else if i > slab + 1u {
            // The next slab shares a margin with this one; any later one is another part of the tube.
            slab = SEVERAL_SLABS;
            break;
        }
    }
    vertex_slab[vertex] = slab;
    if slab < bent.slab_count {
        mapped[vertex] = map_to_slab(slabs[slab], q);
    }
}

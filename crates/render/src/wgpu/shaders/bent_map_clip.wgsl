// Pass 3: clips each listed triangle to its slab in the scene, into a fan of patches. Follows bent_map.wgsl.

@group(0) @binding(2) var<storage, read> positions: array<f32>;
@group(0) @binding(3) var<storage, read> indices: array<u32>;
@group(0) @binding(4) var<storage, read> work: array<ToClip>;
@group(0) @binding(5) var<storage, read_write> counts: BentCounts;
@group(0) @binding(6) var<storage, read_write> patches_out: array<Patch>;

// Three corners, and one more for each of the six planes.
const MAX_CORNERS = 9u;

fn corner(triangle: u32, k: u32) -> vec3f {
    let vertex = indices[3u * triangle + k];
    return tube_position(positions[3u * vertex], positions[3u * vertex + 1u], positions[3u * vertex + 2u]);
}

// Returns the intersection of an edge with a plane. It is always computed from the outer end, so that the triangles on
// both sides of the edge agree bit for bit.
fn crossing(outer: vec3f, outer_distance: f32, inner: vec3f, inner_distance: f32) -> vec3f {
    return outer + (inner - outer) * (outer_distance / (outer_distance - inner_distance));
}

@compute @workgroup_size(64)
fn clip_triangles(@builtin(global_invocation_id) id: vec3u) {
    if id.x >= min(atomicLoad(&counts.items[0]), bent.work_capacity) {
        return;
    }
    let item = work[id.x];
    let c = slabs[item.slab].curve;
    var polygon: array<vec3f, MAX_CORNERS>;
    for (var k = 0u; k < 3u; k++) {
        polygon[k] = corner(item.triangle, k);
    }
    var corners = 3u;
    for (var plane = 0u; plane < 6u && corners >= 3u; plane++) {
        var kept: array<vec3f, MAX_CORNERS>;
        var kept_count = 0u;
        var before = polygon[corners - 1u];
        var before_distance = slab_plane(item.slab, plane, before);
        for (var k = 0u; k < corners; k++) {
            let here = polygon[k];
            let distance = slab_plane(item.slab, plane, here);
            if before_distance < 0.0 && distance >= 0.0 && kept_count < MAX_CORNERS {
                kept[kept_count] = crossing(before, before_distance, here, distance);
                kept_count += 1u;
            } else if before_distance >= 0.0 && distance < 0.0 && kept_count < MAX_CORNERS {
                kept[kept_count] = crossing(here, distance, before, before_distance);
                kept_count += 1u;
            }
            if distance >= 0.0 && kept_count < MAX_CORNERS {
                kept[kept_count] = here;
                kept_count += 1u;
            }
            before = here;
            before_distance = distance;
        }
        polygon = kept;
        corners = kept_count;
    }
    if corners < 3u {
        return;
    }
    let count = corners - 2u;
    let first = atomicAdd(&counts.items[1], count);
    if first + count > bent.patch_capacity {
        return;
    }
    let mapped_first = map_to_slab(c, polygon[0]);
    var mapped_before = map_to_slab(c, polygon[1]);
    for (var k = 0u; k < count; k++) {
        let mapped_next = map_to_slab(c, polygon[k + 2u]);
        patches_out[first + k] = Patch(
            polygon[0], item.slab, polygon[k + 1u], item.caster, polygon[k + 2u], mapped_first, mapped_before, mapped_next,
        );
        mapped_before = mapped_next;
    }
}

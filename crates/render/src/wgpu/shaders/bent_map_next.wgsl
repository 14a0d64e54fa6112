// Between passes: computes the number of workgroups of the next one. Follows bent_map.wgsl.

@group(0) @binding(2) var<storage, read_write> counts: BentCounts;
@group(0) @binding(3) var<storage, read_write> workgroups: vec3u;

@compute @workgroup_size(1)
fn next_level() {
    let level = counts.level + 1u;
    counts.level = level;
    let capacity = select(bent.patch_capacity, bent.work_capacity, level == 0u);
    workgroups = vec3u((min(atomicLoad(&counts.items[level]), capacity) + 63u) / 64u, 1u, 1u);
}

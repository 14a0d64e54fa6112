// Finds every in-tube root of points in tube space, for `eval` and for tests. Follows tube.wgsl.

struct LocatedRoot {
    segment: u32,
    u: f32,
    v_len: f32,
    w_len: f32,
    radius: f32,
    // Unit vector in tube space, from the point to the origin of its light.
    direction: vec3f,
}

@group(0) @binding(0) var<storage, read> points: array<vec4f>;
// Number of roots of each point.
@group(0) @binding(1) var<storage, read_write> root_counts: array<u32>;
// Capacity for two per segment and one on the extension.
@group(0) @binding(2) var<storage, read_write> located: array<LocatedRoot>;

fn report(point: u32, count: u32, root: TubeRoot) {
    let stride = 2u * light.segment_count + u32(EXTENDED);
    located[point * stride + count] =
        LocatedRoot(root.segment, root.u, root.vw_len.x, root.vw_len.y, root.radius, direction_at(root));
}

@compute @workgroup_size(64)
fn locate(@builtin(global_invocation_id) id: vec3u) {
    let point = id.x;
    if point >= arrayLength(&points) {
        return;
    }
    let q = points[point].xyz;
    var count = 0u;
    var last_segment = 0u;
    var last_u = -1.0;
    var f0 = first_joint(q);
    for (var i = 0u; i < light.segment_count + u32(EXTENDED); i++) {
        let f1 = end_joint(i, q);
        let roots = candidates(i, q, f0, f1);
        let us = vec2f(roots.left, roots.right);
        let has = vec2<bool>(roots.has_left, roots.has_right);
        for (var side = 0u; side < 2u; side++) {
            // The same root seen from both sides of a joint belongs to the lower segment.
            let same = count > 0u && f32(i - last_segment) + (us[side] - last_u) < JOINT_MERGE;
            if !has[side] || same {
                continue;
            }
            let inside = inside_at(i, q, us[side]);
            if inside.found {
                report(point, count, root_at(inside, q));
                count += 1u;
                last_segment = i;
                last_u = us[side];
            }
        }
        f0 = f1;
    }
    root_counts[point] = count;
}

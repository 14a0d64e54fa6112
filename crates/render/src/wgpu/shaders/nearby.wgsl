// Traces the last piece of the light path to a surface through the scene. A shadow map cannot separate a caster from
// its receiver if both are within its tolerance, which is long where light grazes. Follows surface.wgsl,
// alpha_test.wgsl, links.wgsl or no_links.wgsl, and subgroups.wgsl or no_subgroups.wgsl.

// Depth-first order. After a skipped node comes `next`, after any other the following one.
struct HierarchyNode {
    min: vec3f,
    // Number of triangles of a leaf, from `next` on in `hierarchy_triangles`. Zero: the node has children.
    count: u32,
    max: vec3f,
    next: u32,
}

@group(0) @binding(5) var<storage, read> hierarchy: array<HierarchyNode>;
@group(0) @binding(6) var<storage, read> hierarchy_triangles: array<u32>;
// Contains one test that begins past the last triangle if no triangle has an alpha test.
@group(0) @binding(7) var<storage, read> alpha_tests: array<AlphaTest>;
@group(0) @binding(8) var<storage, read> alpha_texels: array<u32>;

// Bounds the rounding error in f32 of positions of this size.
fn rounding(position: vec3f) -> f32 {
    return 0x1p-21 * max(max(abs(position.x), abs(position.y)), abs(position.z));
}

// Returns the point at which light must arrive for the surface to be lit.
fn shadow_position(surface: Surface) -> vec3f {
    return surface.position + surface.terminator_offset * surface.normal;
}

// Returns true if light from the direction `arriving`, a unit vector towards it, passes through the surface's own
// triangle from behind.
fn is_in_its_own_way(surface: Surface, arriving: vec3f) -> bool {
    let facing = dot(surface.geometric_normal, arriving);
    let height = surface.terminator_offset * dot(surface.normal, surface.geometric_normal);
    let through = shadow_position(surface) + arriving * (height / max(-facing, 1e-30));
    let from_behind = facing <= 0.0 && throws_shadow(surface.triangle);
    var met = false;
    if any_in_subgroup(from_behind) {
        let is_within = all(weights_at(corners_of(surface.triangle), through) >= vec3f(0.0));
        met = from_behind && (height <= 0.0 || is_within);
    }
    return met;
}

// Returns true if an alpha-tested triangle has a hole at a point.
fn has_hole(triangle: u32, weights: vec3f) -> bool {
    let test = alpha_tests[test_of(triangle - alpha_tests[0].first_index / 3u)];
    let first = 3u * triangle;
    let corners = mat3x3f(uv_alpha(indices[first]), uv_alpha(indices[first + 1u]), uv_alpha(indices[first + 2u]));
    let here = corners * weights;
    return test.factor * here.z * texel_alpha(picture_of(test), here.xy) < test.cutoff;
}

// Returns true if light that was at `there` just before it arrives in front of the surface came through the surface's
// own triangle, as only bent light may.
fn is_behind_its_own(surface: Surface, there: vec3f) -> bool {
    let height = dot(surface.geometric_normal, there - surface.position);
    let is_behind = height < -(rounding(there) + 0x1p-21 * surface.depth) && throws_shadow(surface.triangle);
    let weights = weights_at(corners_of(surface.triangle), there);
    var came_through = is_behind && all(weights >= vec3f(0.0));
    if came_through && surface.triangle >= alpha_tests[0].first_index / 3u {
        came_through = !has_hole(surface.triangle, weights);
    }
    return came_through;
}

// Returns true if a segment stays farther than `slack` from a node's box. Tests separating axes: those of the box, and
// those perpendicular to one of them and to the segment (Ericson, Real-Time Collision Detection, 5.3.3). The segment
// extends from `middle` by `half` in both directions.
fn is_beside(node: HierarchyNode, middle: vec3f, half: vec3f, slack: f32) -> bool {
    let between = 0.5 * (node.min + node.max) - middle;
    let box_half = (0.5 + 0x1p-21) * (node.max - node.min) + slack;
    let reach = abs(half);
    let across = box_half.yzx * reach.zxy + box_half.zxy * reach.yzx;
    return any(abs(between) > box_half + reach) || any(abs(cross(half, between)) > across);
}

// No triangle's index.
const NONE = 0xffffffffu;

// Returns true if a triangle that casts shadows, and has no hole there, lies between `start` and `start + way`, other
// than `own`, and outside the rounding of a surface at distance `depth` from the viewer.
fn is_met(start: vec3f, way: vec3f, own: u32, depth: f32) -> bool {
    let end_point = start + way;
    let slack = rounding(start) + 0x1p-21 * depth;
    let room = slack + rounding(end_point);
    // The bound, not a branch, lets a group of pixels without a path finish at once on a software driver.
    let end = select(0u, arrayLength(&hierarchy), any(way != vec3f(0.0)));
    let first_tested = alpha_tests[0].first_index / 3u;
    var met = false;
    var index = 0u;
    while index < end && !met {
        let node = hierarchy[index];
        let is_leaf = node.count > 0u;
        let passed_by = is_beside(node, start + 0.5 * way, 0.5 * way, room);
        let count = select(node.count, 0u, passed_by);
        for (var k = 0u; k < count; k++) {
            let triangle = hierarchy_triangles[node.next + k];
            let plane = planes[triangle];
            let start_height = dot(plane.xyz, start) - plane.w;
            let end_height = dot(plane.xyz, end_point) - plane.w;
            if triangle != own && abs(start_height) > slack && start_height * end_height < 0.0 {
                let at = start + way * (start_height / (start_height - end_height));
                let weights = weights_at(corners_of(triangle), at);
                var is_there = all(weights >= vec3f(-1e-6)) && throws_shadow(triangle);
                let tests = select(0u, 1u, is_there && triangle >= first_tested);
                for (var test = 0u; test < tests; test++) {
                    is_there = !has_hole(triangle, weights);
                }
                met = met || is_there;
            }
        }
        index = select(index + 1u, node.next, passed_by && !is_leaf);
    }
    return met;
}

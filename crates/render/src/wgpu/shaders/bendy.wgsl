// A BendyLight's contribution to the picture. Follows bent_lookup.wgsl, lighting.wgsl, shadow_filter.wgsl and
// nearby.wgsl.

@group(2) @binding(2) var shadow_map: texture_2d_array<f32>;
@group(2) @binding(3) var shadow_sampler: sampler;

fn sample_light(surface: Surface) -> LightSample {
    let q = (light.tube_from_scene * vec4f(surface.position, 1.0)).xyz;
    let inside = nearest_inside(q);
    if !inside.found {
        return LightSample();
    }
    let root = root_at(inside, q);
    let place = coords_at(root);
    let unshadowed = light_profile_irradiance(light.light_profile, root.emission, place);
    if !SHADOWED {
        return LightSample(true, place, unshadowed, 1.0);
    }
    return LightSample(true, place, unshadowed, bent_visibility(root, place.vw, surface));
}

fn light_profile() -> LightProfile {
    return light.light_profile;
}

// Returns the derivative of position by t along the curve of constant (v, w), which is the light path.
fn path_tangent(root: TubeRoot, vw: vec2f, across: mat2x3f) -> vec3f {
    let turn = u_hat_derivative(root);
    return root.u_hat * (2.0 * length(root.d) - dot(root.r, turn)) + (across * vw) * root.radius_derivative
        + cross(root.u_hat, root.r) * twist(root, turn);
}

// Returns the speed that scales a map's error along the light, for a path at (v, w). On a wide cone it differs much
// from that of the center. Twin of stretch_at in bent_map_split.wgsl.
fn map_speed(center_speed: f32, radius_derivative: f32, vw: vec2f) -> f32 {
    if !SHADOW_CUBE {
        return center_speed;
    }
    return length(vec2f(center_speed, radius_derivative * length(vw)));
}

// A receiver's position on the map, with the plane of the receiver.
struct Receiver {
    face: u32,
    texel: vec2f,
    // Depth as the face stores it, and its change along the receiver's plane per texel.
    depth: f32,
    step: vec2f,
    // Largest depth beyond the map's at which the receiver is lit: by the map's error alone, and if the scene decides
    // on near casters.
    tolerance: f32,
    reach: f32,
    // Value of depth 1.
    far: f32,
}

// Returns the width in tube space of a step of one texel on the map, for a path with the tangent `tangent`.
fn texel_width(texel: MapTexel, radius: f32, across: mat2x3f, tangent: vec3f) -> f32 {
    if !SHADOW_CUBE {
        return radius * max(length(texel.right), length(texel.down));
    }
    // Far off the axis of a wide cone, directions across the tube are almost along the path.
    let along = normalize(tangent);
    let right = across * texel.right;
    let down = across * texel.down;
    return radius * max(length(right - along * dot(right, along)), length(down - along * dot(down, along)));
}

// Lengths along the light in texel widths, compared with the run of the receiver's plane along the light per texel.
// Above GRAZING, the scene decides cases that the map cannot. Above EDGE_ON, the scene decides regardless of the map.
// The map's tolerance counts a slope of at most STEEP, and the mesh error one of at most STEEP_CASTER. STEEPEST bounds
// the run of a plane seen edge on.
const GRAZING = 1.0;
const EDGE_ON = 256.0;
const STEEP = 4.0;
const STEEP_CASTER = 32.0;
const STEEPEST = 4096.0;
// The scene decides on casters nearer than REACH, where light grazes, or NEAR_REACH elsewhere, or nearer than the plane
// runs to the farthest of the texels around, STEPS_AROUND texels away.
const REACH = 48.0;
const NEAR_REACH = 8.0;
const STEPS_AROUND = 1.5;

// Tube coordinates of a point beside a root's, which may be beyond the rim.
struct Lifted {
    dt: f32,
    vw_len: vec2f,
    radius: f32,
}

// Computes the tube coordinates of the point `lift` away from a root's point. Second-order in `lift`, which is short.
// `sigma` is |P'| - r . u_hat'.
fn lifted_root(root: TubeRoot, lift: vec3f, sigma: f32) -> Lifted {
    // grad t = u_hat / sigma, then a step of Newton's method on r . P'.
    let rough = dot(lift, root.u_hat) / max(sigma, 1e-20);
    let d = root.d + root.a * rough;
    let r = root.r + lift - (2.0 * root.d + root.a * rough) * rough;
    let slope = 2.0 * dot(d, d) - dot(r, root.a);
    let dt = rough + select(0.0, dot(r, d) / slope, slope > 0.0);
    let r_there = root.r + lift - (2.0 * root.d + root.a * dt) * dt;
    let d_there = root.d + root.a * dt;
    let u_hat = d_there * inverseSqrt(max(dot(d_there, d_there), 1e-37));
    // The frame turns with the tangent, and in the "up" mode also about it.
    let v_hat = root.v_hat - (root.u_hat + u_hat) * (dot(root.v_hat, u_hat) / (1.0 + dot(root.u_hat, u_hat)));
    let vw_len = r_there * mat2x3f(v_hat, cross(u_hat, v_hat));
    let turned = twist(root, u_hat_derivative(root)) * dt;
    let radius = root.radius + (root.radius_derivative + root.ar * dt) * dt;
    return Lifted(dt, vw_len + turned * vec2f(vw_len.y, -vw_len.x), max(radius, 0.0));
}

// Returns the share of the arriving light that is not blocked.
//
// Each texel is compared with the t of the receiver's own plane at that texel's center, so that a plane cannot shadow
// itself: a step e in the plane is R (dv v_hat + dw w_hat) + T dt with T the path's tangent, and n.e = 0 gives dt = -R
// (n_v dv + n_w dw) / n.T.
fn bent_visibility(root: TubeRoot, vw: vec2f, surface: Surface) -> f32 {
    let across = mat2x3f(root.v_hat, cross(root.u_hat, root.v_hat));
    let tangent = path_tangent(root, vw, across);
    let arriving = -normalize(light.world_from_tube * tangent);
    // Light from behind lights the surface's other side.
    if dot(surface.normal, arriving) <= 0.0 || is_in_its_own_way(surface, arriving) {
        return 0.0;
    }

    let center_speed = 2.0 * length(root.d);
    let sigma = max(center_speed - dot(root.r, u_hat_derivative(root)), 0.1 * center_speed);
    let lift = surface.terminator_offset / light.world_per_tube * (surface.normal * light.world_from_tube);
    let lifted = lifted_root(root, lift, sigma);
    let t = tube_root_t(root) + lifted.dt;
    let radius = lifted.radius;
    let on_map = map_texel(lifted.vw_len, radius);

    // A facet that faces away is behind the plane of the smooth surface.
    let faces_light = dot(surface.geometric_normal, arriving) > 0.0;
    let normal = select(surface.normal, surface.geometric_normal, faces_light) * light.world_from_tube;
    let leaning = normal * across;
    // Width of a texel in the scene, as a step in t; at most that by the speed that scales the map's own error.
    let speed = max(min(length(tangent), map_speed(center_speed, root.radius_derivative, vw)), 1e-20);
    let footprint = texel_width(on_map, radius, across, tangent) / speed;

    var receiver: Receiver;
    receiver.face = on_map.face;
    receiver.texel = on_map.texel;
    receiver.depth = (t - light.map_t_base) * on_map.gain;
    receiver.far = on_map.far;
    // Seen edge on, the plane runs off along the light within a texel, in the direction of its slope.
    let edge_on = length(leaning) * speed;
    let facing = max(-dot(normal, tangent), edge_on / STEEPEST);
    let step_t = radius / facing * vec2f(dot(leaning, on_map.right), dot(leaning, on_map.down));
    receiver.step = step_t * on_map.gain + vec2f(0.0, (t - light.map_t_base) * on_map.gain_down);
    // Depth is rounded to a few ulps of the largest. The receiver's own caster may deviate by e towards the light: the
    // plane, shifted by e along its normal, is hit e / (n . T) earlier.
    let width = footprint * on_map.gain;
    receiver.tolerance = light.shadow_tolerance_texels * (width + min(length(receiver.step), STEEP * width))
        + (0x1p-22 * light.map_t_last + light.mesh_error / max(facing, edge_on / STEEP_CASTER)) * on_map.gain;
    let run = length(receiver.step);
    let grazes = !faces_light || run > GRAZING * width;
    receiver.reach = max(receiver.tolerance, max(select(NEAR_REACH, REACH, grazes) * width, STEPS_AROUND * run));

    // Beside the receiver a steep caster may be nearer than at it, so the scene is tested over twice the reach.
    let shares = filtered(receiver);
    let is_untold = asks_scene(shares, grazes) || shares.x < shares.y;
    let asks = is_untold || run > EDGE_ON * width && shares.y > 0.0;
    let back = select(2.0 * REACH * width, 2.0 * receiver.reach + run, is_untold) / on_map.gain;
    let vw_there = lifted.vw_len / select(1.0, radius, radius > 0.0);
    var met = false;
    if any_in_subgroup(asks) {
        let pieces = clamp(ceil(log2(back * on_map.gain / (FIRST_PIECE * width))) + 1.0, 1.0, MOST_PIECES);
        met = is_met_on_path(surface, faces_light, vec3f(t, vw_there), select(0.0, back, asks), pieces);
    }
    return decided(shares, asks, met);
}

// Returns the point of the path of constant (v, w) at `t`, in tube space.
fn path_point(t: f32, vw: vec2f) -> vec3f {
    let last = segment_count() - select(1u, 0u, EXTENDED);
    let i = min(u32(t), last);
    let c = segment_at(i).curve;
    let u = t - f32(i);
    let across = cross_section(c, curve_u_hat(c, u), FRAME_UP, light.up);
    return c.b0 + (c.d0 * 2.0 + c.a * u) * u + across * (vw * curve_radius(c, u));
}

// The path is traced in pieces, each as long as all that are nearer to the surface, because the error of a chord is
// smaller near the surface. The first has at most FIRST_PIECE texel widths, so the error of its chord is a few
// hundredths of a texel, unless there are MOST_PIECES.
const FIRST_PIECE = 16.0;
const MOST_PIECES = 12.0;

// Returns true if a triangle blocks the path of constant (v, w) that ends at a surface, at (t, v, w), within `back` of
// t before it. Traces nothing if `back` is 0.
fn is_met_on_path(surface: Surface, faces_light: bool, place: vec3f, back: f32, pieces: f32) -> bool {
    let end = shadow_position(surface);
    let turns = select(0u, u32(pieces) + 1u, back > 0.0);
    var end_on_path = vec3f(0.0);
    var before = end;
    // Bent light may have come through the surface's own triangle earlier.
    var own = surface.triangle;
    var met = false;
    for (var turn = 0u; turn < turns && !met; turn++) {
        // The first point is the path's own end.
        let share = select(exp2(f32(turn) - pieces), 0.0, turn == 0u);
        let point = path_point(max(place.x - back * share, 0.0), place.yz);
        end_on_path = select(end_on_path, point, turn == 0u);
        let here = end + light.world_from_tube * (point - end_on_path) * light.world_per_tube;
        met = is_met(before, here - before, own, surface.depth)
            || turn == 1u && faces_light && is_behind_its_own(surface, here);
        before = here;
        own = select(NONE, own, turn == 0u);
    }
    return met;
}

// Flags of the four texels from `corner` on that let the light through, in the order of textureGather.
fn lit_texels(receiver: Receiver, corner: vec2f) -> mat2x4f {
    // Beyond the border where the tube's rim touches it, the lookup uses the next texel inside. Farther out there are
    // no casters, although surfaces that need not cast may be drawn up to the map's border.
    let beyond = any(receiver.texel < vec2f(-1.5)) || any(receiver.texel > vec2f(light.shadow_resolution + 0.5));
    let first = clamp(corner, vec2f(0.0), vec2f(light.shadow_resolution - 2.0));
    let step = receiver.step;
    let expected = receiver.depth + dot(step, first - receiver.texel) + vec4f(step.y, step.x + step.y, step.x, 0.0);
    // An empty texel holds the last depth, and a plane may run beyond it.
    let latest = vec4f(receiver.far * (1.0 - 0x1p-22));
    let place = (first + 1.0) / light.shadow_resolution;
    let stored = textureGather(0, shadow_map, shadow_sampler, place, receiver.face) * receiver.far;
    return mat2x4f(
        select(vec4f(0.0), vec4f(1.0), stored >= min(expected - receiver.tolerance, latest) | vec4<bool>(beyond)),
        select(vec4f(0.0), vec4f(1.0), stored >= min(expected - receiver.reach, latest) | vec4<bool>(beyond)),
    );
}

// A BendyLight's share of the picture. Follows tube.wgsl, lighting.wgsl and shadow_filter.wgsl.

@group(2) @binding(2) var shadow_map: texture_2d<f32>;
@group(2) @binding(3) var shadow_sampler: sampler;

fn sample_light(surface: Surface) -> LightSample {
    let q = (light.tube_from_scene * vec4f(surface.position, 1.0)).xyz;
    let place = nearest_place(q);
    if !place.found {
        return LightSample();
    }
    let root = root_at(place, q);
    var result: LightSample;
    result.inside = true;
    result.t = root_t(root);
    result.vw = root.vw_len / select(1.0, root.radius, root.radius > 0.0);
    result.to_light = normalize(light.world_from_tube * direction_at(root));
    result.irradiance = irradiance(root);
    result.visibility = bent_visibility(root, result.vw, surface.geometric_normal * light.world_from_tube);
    return result;
}

// Derivative of position by t along the curve of constant (v, w): the way light takes.
fn path_tangent(root: Root, vw: vec2f, across: mat2x3f) -> vec3f {
    let turn = turn_at(root);
    return root.u_hat * (2.0 * length(root.d) - dot(root.r, turn)) + (across * vw) * root.radius_derivative
        + cross(root.u_hat, root.r) * twist(root, turn);
}

// A receiver's place on the map, and what its own plane looks like there.
struct Receiver {
    texel: vec2f,
    t: f32,
    // How t changes along the receiver's plane from texel to texel.
    step: vec2f,
    tolerance: f32,
}

// Each texel is compared with the t that the receiver's own plane has at that texel's centre, so that a plane cannot
// shadow itself: a step e in the plane is R (dv v_hat + dw w_hat) + T dt with T the path's tangent, and n.e = 0 gives
// dt = -R (n_v dv + n_w dw) / n.T.
fn bent_visibility(root: Root, vw: vec2f, normal: vec3f) -> f32 {
    let across = mat2x3f(root.v_hat, cross(root.u_hat, root.v_hat));
    let tangent = path_tangent(root, vw, across);
    let texel_width = 2.0 * root.radius / light.shadow_resolution;
    // One texel's width in the scene, as a step in t; at most that along the centre, in which the map's own
    // error is measured.
    let speed = max(min(length(tangent), 2.0 * length(root.d)), 1e-20);
    let footprint = texel_width / speed;
    let closing = -dot(normal, tangent);
    // Light that arrives from behind meets the surface's other side.
    if closing <= 0.0 {
        return 0.0;
    }
    let leaning = normal * across;

    var receiver: Receiver;
    receiver.texel = (vw * vec2f(0.5, -0.5) + 0.5) * light.shadow_resolution - 0.5;
    receiver.t = root_t(root);
    // Seen edge on, the plane runs off along the light within a texel: at most 32 of its widths, the way it leans.
    let facing = max(closing, length(leaning) * speed / 32.0);
    receiver.step = texel_width / facing * vec2f(leaning.x, -leaning.y);
    // The depth is rounded to some ulps of 1. And the receiver's own caster may stray by e towards the light: a plane
    // moved so far along its normal is met e / (n . T) earlier.
    receiver.tolerance = light.shadow_tolerance_texels * (footprint + length(receiver.step))
        + 0x1p-22 * light.t_max + light.mesh_error / facing;

    return filtered(receiver);
}

// Which of the four texels from `corner` on let the light through, in the order of textureGather.
fn lit_texels(receiver: Receiver, corner: vec2f) -> vec4f {
    // The tube's rim touches the map's: what lies beyond is looked up a texel further in.
    let first = clamp(corner, vec2f(0.0), vec2f(light.shadow_resolution - 2.0));
    let step = receiver.step;
    let expected = receiver.t + dot(step, first - receiver.texel) + vec4f(step.y, step.x + step.y, step.x, 0.0);
    // A texel that nothing was drawn to holds t_max, and a plane may run on past the light's end.
    let needed = min(expected - receiver.tolerance, vec4f(light.t_max * (1.0 - 0x1p-22)));
    let stored = textureGather(0, shadow_map, shadow_sampler, (first + 1.0) / light.shadow_resolution) * light.t_max;
    return select(vec4f(0.0), vec4f(1.0), stored >= needed);
}

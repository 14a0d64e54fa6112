// A spotlight's contribution to the picture, with its own perspective shadow map. Follows cone.wgsl, spot_faces.wgsl,
// lighting.wgsl, shadow_filter.wgsl and nearby.wgsl.

@group(2) @binding(1) var shadow_map: texture_2d_array<f32>;
@group(2) @binding(2) var shadow_sampler: sampler;

fn sample_light(surface: Surface) -> LightSample {
    let located = locate(surface.position);
    if !located.inside {
        return LightSample();
    }
    let place = located.place;
    let unshadowed = light_profile_irradiance(spot.light_profile, vec3f(1.0), place);
    if !SHADOWED {
        return LightSample(true, place, unshadowed, 1.0);
    }
    return LightSample(true, place, unshadowed, shadow_visibility(surface, place.direction));
}

fn light_profile() -> LightProfile {
    return spot.light_profile;
}

// A receiver's position on the map, with the plane of the receiver.
struct Receiver {
    face: u32,
    texel: vec2f,
    // 1 / depth, and its change along the receiver's plane per texel.
    inverse_depth: f32,
    step: vec2f,
    // Largest 1 / depth above the receiver's, in the map's units, at which the receiver is lit: by the map's error
    // alone, and if the scene decides on near casters.
    tolerance: f32,
    reach: f32,
    // Largest change of 1 / depth on the receiver's plane over the texels around, as a share.
    most: f32,
}

// Lengths along the light in texel widths. If the receiver's plane runs farther than GRAZING per texel, the scene
// decides cases that the map cannot. Beyond REACH it is followed only as far as the texels around need.
const GRAZING = 1.0;
const REACH = 48.0;

// Returns the share of the arriving light that is not blocked.
//
// Each texel is compared with the depth of the receiver's own plane on the ray through that texel's center, so that a
// plane cannot shadow itself.
fn shadow_visibility(surface: Surface, to_light: vec3f) -> f32 {
    // Light from behind lights the surface's other side.
    if dot(surface.normal, to_light) <= 0.0 || is_in_its_own_way(surface, to_light) {
        return 0.0;
    }
    // A facet that faces away is behind the plane of the smooth surface.
    let faces_light = dot(surface.geometric_normal, to_light) > 0.0;
    let world_normal = select(surface.normal, surface.geometric_normal, faces_light);
    let position_in_light = (spot.light_from_scene * vec4f(shadow_position(surface), 1.0)).xyz;
    let face = face_of(position_in_light);
    let position = on_face(face, position_in_light);
    let normal = on_face(face, scene_axes() * world_normal);
    let depth = max(position.z, 1e-30);
    let resolution = vec2f(textureDimensions(shadow_map));
    let fit = fit_of(face);

    // On the ray (x, y, 1) the plane through `position` has 1 / depth = n.(x, y, 1) / n.position: linear in (x, y).
    let texel_slopes = 2.0 / (fit.zw * resolution);
    let texel_slope = max(texel_slopes.x, texel_slopes.y);
    let plane_distance = min(dot(normal, position), -1e-30);
    let across = normal.xy / plane_distance;

    var receiver: Receiver;
    receiver.face = face;
    receiver.texel = ((position.xy / depth - fit.xy) * fit.zw * vec2f(0.5, -0.5) + 0.5) * resolution - 0.5;
    receiver.inverse_depth = 1.0 / depth;
    receiver.step = across * texel_slopes * vec2f(1.0, -1.0);
    // An adjacent facet that rises out of this plane by 0.25 rad is not an occluder: that many texels of depth, more
    // where light grazes. The map's depth, linear across a triangle, has an error of a few ulps of its largest value,
    // 1.
    let cosine = plane_distance / length(position);
    receiver.tolerance = 0.25 * texel_slope / max(cosine * cosine, 0.06) * spot.shadow_near / depth + 0x1p-22;
    // The receiver's own caster may deviate by e towards the light. The plane, shifted by e along its normal, has
    // n.position = D + e in place of D < 0, so on the same ray 1 / depth is larger by the share e / (|D| - e). That is
    // at most its own size, and the cosine of grazing light counts as at least 0.1.
    let plane_height = max(-plane_distance, 0.1 * length(position));
    let nearer = spot.mesh_error / max(plane_height - spot.mesh_error, spot.mesh_error);
    receiver.tolerance += nearer * spot.shadow_near / depth;

    // Seen edge on, the plane runs off to the source or to infinity within a texel. It is followed to the texels
    // around, except in the first tenth of the light path.
    let run = length(receiver.step) * depth;
    let around = 1.5 * run;
    receiver.most = max(min(REACH * texel_slope, 0.5), min(around / (1.0 + around), 0.9));
    receiver.reach = max(receiver.tolerance, receiver.most / (1.0 - receiver.most) * spot.shadow_near / depth);

    // Beside the receiver a steep caster may be nearer than at it, so the scene is tested over twice the reach, and as
    // far as the plane runs in the texels around.
    let grazes = !faces_light || run > GRAZING * texel_slope;
    let way = to_light * (length(position) * min(3.0 * receiver.most, 0.9));
    return decided_along(surface, filtered(receiver), grazes, way);
}

// Flags of the four texels from `first` on that let the light through, in the order of textureGather.
fn lit_texels(receiver: Receiver, first: vec2f) -> mat2x4f {
    let step = receiver.step;
    let start = receiver.inverse_depth + dot(step, first - receiver.texel);
    let plane_at = start + vec4f(step.y, step.x + step.y, step.x, 0.0);
    let bounds = vec2f(1.0 - receiver.most, 1.0 / (1.0 - receiver.most)) * receiver.inverse_depth;
    let expected = clamp(plane_at, vec4f(bounds.x), vec4f(bounds.y)) * spot.shadow_near;
    let resolution = vec2f(textureDimensions(shadow_map));
    let stored = textureGather(0, shadow_map, shadow_sampler, (first + 1.0) / resolution, receiver.face);
    let beyond = beyond_map(first, resolution);
    return mat2x4f(
        select(vec4f(0.0), vec4f(1.0), beyond | (stored <= expected + receiver.tolerance)),
        select(vec4f(0.0), vec4f(1.0), beyond | (stored <= expected + receiver.reach)),
    );
}

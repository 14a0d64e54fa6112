// A directional light's contribution to the picture. Its shadow map is orthographic along its rays. Follows
// parallel.wgsl, lighting.wgsl, shadow_filter.wgsl and nearby.wgsl.

@group(2) @binding(1) var shadow_map: texture_2d_array<f32>;
@group(2) @binding(2) var shadow_sampler: sampler;

fn sample_light(surface: Surface) -> LightSample {
    let located = locate(surface.position);
    if !located.inside {
        return LightSample();
    }
    let place = located.place;
    let unshadowed = light_profile_irradiance(directional.light_profile, vec3f(1.0), place);
    if !SHADOWED {
        return LightSample(true, place, unshadowed, 1.0);
    }
    return LightSample(true, place, unshadowed, shadow_visibility(surface, place.direction));
}

fn light_profile() -> LightProfile {
    return directional.light_profile;
}

// A position on the map, with the receiver's plane. Lengths along the light are in map depths.
struct Receiver {
    texel: vec2f,
    depth: f32,
    // Rise of the plane per texel; it is followed at most up to `most`.
    step: vec2f,
    most: f32,
    // Largest height above the plane's at which the receiver is lit: by the map's error alone, and if the scene decides
    // on near casters.
    tolerance: f32,
    reach: f32,
}

// Lengths along the light in texel widths. If the receiver's plane runs farther than GRAZING per texel, the scene
// decides cases that the map cannot. The plane is followed beyond REACH only as far as the texels around need.
const GRAZING = 1.0;
const REACH = 48.0;

// Returns the share of the arriving light that is not blocked. Each texel is compared with the height of the receiver's
// own plane at its center, so that a plane cannot shadow itself.
fn shadow_visibility(surface: Surface, to_light: vec3f) -> f32 {
    // Light from behind lights the surface's other side.
    if dot(surface.normal, to_light) <= 0.0 || is_in_its_own_way(surface, to_light) {
        return 0.0;
    }
    // A facet that faces away is behind the plane of the smooth surface.
    let faces_light = dot(surface.geometric_normal, to_light) > 0.0;
    let scene_normal = select(surface.normal, surface.geometric_normal, faces_light);
    let start = shadow_position(surface);
    let at = scene_axes() * start;
    let normal = scene_axes() * scene_normal;
    let cosine = max(normal.z, 1e-20);
    let fit = directional.fit;
    let resolution = vec2f(textureDimensions(shadow_map));
    // In world units.
    let texels = 2.0 / (fit.zw * resolution);
    let width = max(texels.x, texels.y);
    let rise = -normal.xy / cosine * texels;

    var receiver: Receiver;
    receiver.texel = ((at.xy - fit.xy) * fit.zw * vec2f(0.5, -0.5) + 0.5) * resolution - 0.5;
    receiver.depth = (at.z - directional.bottom) * directional.depth_scale;
    receiver.step = rise * vec2f(1.0, -1.0) * directional.depth_scale;
    // Nothing is above the range of the map's depths.
    let run = min(max(REACH * width, 1.5 * length(rise)), 1.0 / directional.depth_scale);
    receiver.most = run * directional.depth_scale;
    // An adjacent facet that rises out of the plane by 0.25 rad is no occluder: a quarter of a texel's width, longer
    // along the light where it grazes. The receiver's own caster is none either, and deviates along the normal; the
    // cosine of grazing light counts as at least 0.1. Positions are rounded, and so are the map's depths, up to 1.
    let facets = 0.25 * width / max(cosine * cosine, 0.06);
    let strayed = directional.mesh_error / max(cosine, 0.1);
    receiver.tolerance = (facets + strayed + rounding(start)) * directional.depth_scale + 0x1p-22;
    receiver.reach = max(receiver.tolerance, receiver.most);

    // Beside the receiver a steep caster may be higher than at it. The scene is tested over twice the reach, and as far
    // as the plane rises in the texels around.
    let grazes = !faces_light || length(rise) > GRAZING * width;
    return decided_along(surface, filtered(receiver), grazes, to_light * (3.0 * run));
}

// Flags of the four texels from `first` on that let the light through, in the order of textureGather.
fn lit_texels(receiver: Receiver, first: vec2f) -> mat2x4f {
    let step = receiver.step;
    let rises = dot(step, first - receiver.texel) + vec4f(step.y, step.x + step.y, step.x, 0.0);
    // Nothing is below 0, the value of an empty texel.
    let plane = max(receiver.depth + clamp(rises, vec4f(-receiver.most), vec4f(receiver.most)), vec4f(0.0));
    let resolution = vec2f(textureDimensions(shadow_map));
    let stored = textureGather(0, shadow_map, shadow_sampler, (first + 1.0) / resolution, 0);
    let beyond = beyond_map(first, resolution);
    return mat2x4f(
        select(vec4f(0.0), vec4f(1.0), beyond | (stored <= plane + receiver.tolerance)),
        select(vec4f(0.0), vec4f(1.0), beyond | (stored <= plane + receiver.reach)),
    );
}

// An omni light's contribution to the picture. Its shadow map has the faces of a cube: +x, -x, +y, -y, +z and -z in
// light space, each a perspective picture. Follows omni.wgsl, lighting.wgsl, shadow_filter.wgsl and nearby.wgsl.

@group(2) @binding(1) var shadow_map: texture_2d_array<f32>;
@group(2) @binding(2) var shadow_sampler: sampler;

fn sample_light(surface: Surface) -> LightSample {
    let located = locate(surface.position);
    if !located.inside {
        return LightSample();
    }
    let place = located.place;
    let unshadowed = light_profile_irradiance(omni.light_profile, vec3f(1.0), place);
    if !SHADOWED {
        return LightSample(true, place, unshadowed, 1.0);
    }
    return LightSample(true, place, unshadowed, shadow_visibility(surface, place.direction));
}

fn light_profile() -> LightProfile {
    return omni.light_profile;
}

// Returns the face that contains a position in light space.
fn face_of(position: vec3f) -> u32 {
    let size = abs(position);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
    let ahead = select(select(position.z, position.y, axis == 1u), position.x, axis == 0u);
    return 2u * axis + select(0u, 1u, ahead < 0.0);
}

// Returns a vector in a face's axes: right, up and ahead. Right and up are the axes that follow the face's own
// cyclically, on both faces of an axis. One of the two faces is mirrored, and no angle changes.
fn seen_on(face: u32, v: vec3f) -> vec3f {
    let axis = face / 2u;
    let turned = select(select(v, v.zxy, axis == 1u), v.yzx, axis == 0u);
    return turned * vec3f(1.0, 1.0, select(1.0, -1.0, face % 2u == 1u));
}

// Returns the center and 1 / half size of the drawn part of a face. Selected, not indexed: a software driver gathers
// one number after another.
fn fit_of(face: u32) -> vec4f {
    let x = select(omni.fits[0], omni.fits[1], face == 1u);
    let y = select(omni.fits[2], omni.fits[3], face == 3u);
    let z = select(omni.fits[4], omni.fits[5], face == 5u);
    return select(select(z, y, face / 2u == 1u), x, face / 2u == 0u);
}

// A position on a face of the map, with the receiver's plane. The map stores nearness, the near plane's distance
// divided by the distance ahead. It is linear on a plane: 1 on the near plane, 0 at infinity.
struct Receiver {
    face: u32,
    texel: vec2f,
    nearness: f32,
    // Change per texel.
    step: vec2f,
    // Limits of the plane's nearness.
    least: f32,
    most: f32,
    // Largest nearness above the plane's at which the receiver is lit: by the map's error alone, and if the scene
    // decides on near casters.
    tolerance: f32,
    reach: f32,
}

// Lengths along the light in texel widths. If the receiver's plane runs farther than GRAZING per texel, the scene
// decides cases that the map cannot. The plane is followed beyond REACH only as far as the texels around need.
const GRAZING = 1.0;
const REACH = 48.0;

// Returns the share of the arriving light that is not blocked. Each texel is compared with the nearness of the
// receiver's own plane at its center, so that a plane cannot shadow itself.
fn shadow_visibility(surface: Surface, to_light: vec3f) -> f32 {
    // Light from behind lights the surface's other side.
    if dot(surface.normal, to_light) <= 0.0 || is_in_its_own_way(surface, to_light) {
        return 0.0;
    }
    // A facet that faces away is behind the plane of the smooth surface.
    let faces_light = dot(surface.geometric_normal, to_light) > 0.0;
    let scene_normal = select(surface.normal, surface.geometric_normal, faces_light);
    let in_light = (omni.light_from_scene * vec4f(shadow_position(surface), 1.0)).xyz;
    let face = face_of(in_light);
    let fit = fit_of(face);
    let resolution = vec2f(textureDimensions(shadow_map));
    let at = seen_on(face, in_light);
    let normal = seen_on(face, scene_axes() * scene_normal);
    let ahead = max(at.z, 1e-30);
    let way_length = length(at);

    // Slopes per texel, and the width of a texel at the receiver.
    let slopes = 2.0 / (fit.zw * resolution);
    let width = max(slopes.x, slopes.y) * ahead;
    // Height of the source above the plane. On the ray along e the plane is at e times height / -(normal . e), so its
    // nearness is linear in e.
    let height = max(-dot(normal, at), 1e-30);

    var receiver: Receiver;
    receiver.face = face;
    receiver.texel = ((at.xy / ahead - fit.xy) * fit.zw * vec2f(0.5, -0.5) + 0.5) * resolution - 0.5;
    receiver.nearness = omni.shadow_near / ahead;
    receiver.step = -normal.xy / height * slopes * vec2f(1.0, -1.0) * omni.shadow_near;
    // Seen edge on, the plane runs off to the source or to infinity within a texel. It is followed as far as the texels
    // around reach, except in the first tenth of the light path.
    let run = length(receiver.step) / receiver.nearness;
    let share = max(min(REACH * width / ahead, 0.5), min(1.5 * run / (1.0 + 1.5 * run), 0.9));
    receiver.least = receiver.nearness * (1.0 - share);
    receiver.most = receiver.nearness / (1.0 - share);

    // An adjacent facet that rises out of the plane by 0.25 rad is no occluder: a quarter of a texel's width, longer
    // along the light where it grazes. The receiver's own caster is none either, and deviates along the normal. The
    // stored value, linear across a triangle, has an error of a few ulps of its largest value, 1.
    let cosine = height / way_length;
    let rise = 0.25 * width / max(cosine * cosine, 0.06);
    let plane_height = max(height, 0.1 * way_length);
    let strayed = omni.mesh_error / max(plane_height - omni.mesh_error, omni.mesh_error);
    receiver.tolerance = receiver.nearness * (rise / ahead + strayed) + 0x1p-22;
    receiver.reach = max(receiver.tolerance, receiver.most - receiver.nearness);

    // Beside the receiver a steep caster may be nearer than at it. The scene is tested over twice the reach, and as far
    // as the plane runs in the texels around.
    let way = to_light * (way_length * min(3.0 * share, 0.9));
    return decided_along(surface, filtered(receiver), !faces_light || run * ahead > GRAZING * width, way);
}

// Flags of the four texels from `first` on that let the light through, in the order of textureGather.
fn lit_texels(receiver: Receiver, first: vec2f) -> mat2x4f {
    let corner = receiver.nearness + dot(receiver.step, first - receiver.texel);
    let right = receiver.step.x;
    let down = receiver.step.y;
    let plane = clamp(corner + vec4f(down, right + down, right, 0.0), vec4f(receiver.least), vec4f(receiver.most));
    let resolution = vec2f(textureDimensions(shadow_map));
    let stored = textureGather(0, shadow_map, shadow_sampler, (first + 1.0) / resolution, receiver.face);
    let excess = stored - plane;
    let beyond = beyond_map(first, resolution);
    return mat2x4f(
        select(vec4f(0.0), vec4f(1.0), beyond | (excess <= vec4f(receiver.tolerance))),
        select(vec4f(0.0), vec4f(1.0), beyond | (excess <= vec4f(receiver.reach))),
    );
}

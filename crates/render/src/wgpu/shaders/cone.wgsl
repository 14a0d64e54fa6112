// Straight rays from a point: a spotlight and the coordinates of a point in it; twin of `light`'s cone.rs. Follows
// profile.wgsl. Light space: source at the origin, the light shines along -z.

struct Spot {
    light_from_scene: mat4x4f,
    light_profile: LightProfile,
    tan_outer: f32,
    // Axial distance at which the light ends; 0 for none.
    range: f32,
    // Near plane of the shadow map.
    shadow_near: f32,
    // Largest distance of casters from the surface.
    mesh_error: f32,
    // See fit_of.
    fits: array<vec4f, 5>,
}

@group(2) @binding(0) var<uniform> spot: Spot;

struct Located {
    inside: bool,
    place: LightCoords,
}

// Coordinates of a scene position in the light.
fn locate(scene_position: vec3f) -> Located {
    let position = (spot.light_from_scene * vec4f(scene_position, 1.0)).xyz;
    let depth = -position.z;
    let slope = position.xy / select(1.0, depth, depth > 0.0);
    let in_range = depth <= select(spot.range, depth, spot.range == 0.0);
    if !(depth > 0.0 && dot(slope, slope) <= spot.tan_outer * spot.tan_outer && in_range) {
        return Located();
    }
    let t = select(depth / spot.range, 0.0, spot.range == 0.0);
    // The axes of a BendyLight's cross-section: w_hat is up, v_hat = w_hat x u_hat is to the left of +x.
    let vw = vec2f(-slope.x, slope.y) / spot.tan_outer;
    return Located(true, LightCoords(t, vw, length(position), normalize(-position * scene_axes())));
}

// Returns the rotation from scene axes to light axes.
fn scene_axes() -> mat3x3f {
    return mat3x3f(spot.light_from_scene[0].xyz, spot.light_from_scene[1].xyz, spot.light_from_scene[2].xyz);
}

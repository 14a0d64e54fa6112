// Parallel rays from infinity: a directional light and the coordinates of a point in it; twin of `light`'s parallel.rs.
// Follows profile.wgsl. Light space: the light's axes around the scene's origin; light travels along -z.

struct Directional {
    light_from_scene: mat4x4f,
    // Coordinates in the window are (-x, y) times the first two plus the others: 0 along an unbounded axis.
    window: vec4f,
    // Center and 1 / half size of the shadow map.
    fit: vec4f,
    light_profile: LightProfile,
    // The z of map depth 0: all of the scene is above it.
    bottom: f32,
    // Map depth per world unit along z.
    depth_scale: f32,
    // Largest distance of casters from the surface.
    mesh_error: f32,
}

@group(2) @binding(0) var<uniform> directional: Directional;

struct Located {
    inside: bool,
    place: LightCoords,
}

// Coordinates of a scene position in the light.
fn locate(scene_position: vec3f) -> Located {
    let across = (scene_axes() * scene_position).xy * vec2f(-1.0, 1.0);
    let vw = across * directional.window.xy + directional.window.zw;
    if !all(abs(vw) <= vec2f(1.0)) {
        return Located();
    }
    return Located(true, LightCoords(0.0, vw, 0.0, direction()));
}

// Returns the unit vector towards the arriving light, the same for all surfaces.
fn direction() -> vec3f {
    return vec3f(0.0, 0.0, 1.0) * scene_axes();
}

// Returns the rotation from scene axes to light axes.
fn scene_axes() -> mat3x3f {
    let columns = directional.light_from_scene;
    return mat3x3f(columns[0].xyz, columns[1].xyz, columns[2].xyz);
}

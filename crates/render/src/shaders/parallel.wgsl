// Parallel rays from infinitely far away, as `light` has them in parallel.rs: a directional light and where a point lies
// in it. Follows profile.wgsl. Light space: the light's axes about the scene's origin; light travels along -z.

struct Directional {
    light_from_scene: mat4x4f,
    // The place across the window is (-x, y) times the first two plus the others: 0 where it has no end.
    window: vec4f,
    // Middle and 1 / half size of what the shadow map shows.
    fit: vec4f,
    light_profile: LightProfile,
    // The z that has the map's depth 0: none of the scene is below.
    bottom: f32,
    // The map's depth a world unit along z.
    depth_scale: f32,
    // How far what casts shadows may stray from the surface.
    mesh_error: f32,
}

@group(2) @binding(0) var<uniform> directional: Directional;

struct Located {
    inside: bool,
    place: LightCoords,
}

// Where a position in the scene lies.
fn locate(scene_position: vec3f) -> Located {
    let across = (scene_axes() * scene_position).xy * vec2f(-1.0, 1.0);
    let vw = across * directional.window.xy + directional.window.zw;
    if !all(abs(vw) <= vec2f(1.0)) {
        return Located();
    }
    return Located(true, LightCoords(0.0, vw, 0.0, direction()));
}

// Unit vector to where all of the light comes from.
fn direction() -> vec3f {
    return vec3f(0.0, 0.0, 1.0) * scene_axes();
}

// Light axes from the scene's.
fn scene_axes() -> mat3x3f {
    let columns = directional.light_from_scene;
    return mat3x3f(columns[0].xyz, columns[1].xyz, columns[2].xyz);
}

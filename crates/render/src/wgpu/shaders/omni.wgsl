// Straight rays from a point in all directions: an omni light and the coordinates of a point in it; twin of `light`'s
// omni.rs. Follows profile.wgsl. Light space: source at the origin.

struct Omni {
    light_from_scene: mat4x4f,
    light_profile: LightProfile,
    // Distance at which the light ends; 0 for none.
    range: f32,
    // Near plane of the shadow map's faces.
    shadow_near: f32,
    // Largest distance of casters from the surface.
    mesh_error: f32,
    // Center and 1 / half size of the drawn part of each face, as slopes.
    fits: array<vec4f, 6>,
}

@group(2) @binding(0) var<uniform> omni: Omni;

struct Located {
    inside: bool,
    place: LightCoords,
}

// Coordinates of a scene position in the light.
fn locate(scene_position: vec3f) -> Located {
    let position = (omni.light_from_scene * vec4f(scene_position, 1.0)).xyz;
    let s = length(position);
    let in_range = s <= select(omni.range, s, omni.range == 0.0);
    if !(s > 0.0 && in_range) {
        return Located();
    }
    let t = select(s / omni.range, 0.0, omni.range == 0.0);
    return Located(true, LightCoords(t, on_cube(position), s, -(position / s) * scene_axes()));
}

// Returns the coordinates, left and up, of the ray along `way` on the face of a cube seen from within.
fn on_cube(way: vec3f) -> vec2f {
    let size = abs(way);
    let is_y = size.y > max(size.x, size.z);
    let is_x = !is_y && size.x > size.z;
    let on_x = vec2f(select(way.z, -way.z, way.x > 0.0), way.y) / size.x;
    let on_y = vec2f(-way.x, select(-way.z, way.z, way.y > 0.0)) / size.y;
    let on_z = vec2f(select(way.x, -way.x, way.z < 0.0), way.y) / size.z;
    return select(select(on_z, on_x, is_x), on_y, is_y);
}

// Returns the rotation from scene axes to light axes.
fn scene_axes() -> mat3x3f {
    return mat3x3f(omni.light_from_scene[0].xyz, omni.light_from_scene[1].xyz, omni.light_from_scene[2].xyz);
}

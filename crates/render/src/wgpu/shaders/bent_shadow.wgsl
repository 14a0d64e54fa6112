// Draws mapped triangles onto a face of the shadow map. The clip position is (X, Y, Z/2, Z), all linear in (V, W, R): a
// straight cone is an ordinary perspective spotlight without tessellation, a constant radius an orthographic one. Depth
// is t, divided by y / depth on the sides of a cube. Neither is linear on the map, so the fragment writes it.

struct BentShadow {
    clip_from_mapped: mat3x3f,
    // y / depth of a row of texels: the first plus the second times the row; on the front 1.
    row: vec2f,
    depth_per_t: f32,
}

@group(0) @binding(0) var<uniform> bent_shadow: BentShadow;

struct Fragment {
    @builtin(position) position: vec4f,
    @location(0) t: f32,
}

fn face_position(mapped: vec4f) -> vec4f {
    let clip = bent_shadow.clip_from_mapped * mapped.xyz;
    return vec4f(clip.xy, 0.5 * clip.z, clip.z);
}

// Returns the depth that the map stores for a fragment at `t`, in row `y` of the face.
fn face_depth(t: f32, y: f32) -> f32 {
    return t * bent_shadow.depth_per_t / (bent_shadow.row.x + bent_shadow.row.y * y);
}

@vertex
fn vs_bent_shadow(@location(0) mapped: vec4f) -> Fragment {
    return Fragment(face_position(mapped), mapped.w);
}

@fragment
fn fs_bent_shadow(in: Fragment) -> @builtin(frag_depth) f32 {
    return face_depth(in.t, in.position.y);
}

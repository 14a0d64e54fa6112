// Depth of the scene from the light, by ordinary rasterization. Reversed z, no far plane.

struct ShadowView {
    clip_from_scene: mat4x4f,
}

@group(0) @binding(0) var<uniform> shadow_view: ShadowView;

@vertex
fn vs_opaque(@location(0) position: vec3f) -> @builtin(position) vec4f {
    return shadow_view.clip_from_scene * vec4f(position, 1.0);
}

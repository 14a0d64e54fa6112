// What each pixel sees, packed in 16 bytes:
//   x  shading normal towards the viewer, octahedral 2 x 16 bits
//   y  index of the triangle + 1; 0 is the background
//   zw base colour, metallic and roughness: material_to_bits
// The position is not stored: surface.wgsl cuts the pixel's ray with the plane of its triangle, which is more
// exact than any depth buffer and gives the geometric normal as well.

struct Varyings {
    @builtin(position) clip: vec4f,
    @location(0) normal: vec3f,
    @location(1) uv: vec2f,
    @location(2) color: vec4f,
}

@vertex
fn vs_gbuffer(
    @location(0) position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
) -> Varyings {
    return Varyings(view.clip_from_scene * vec4f(position, 1.0), normal, uv, color);
}

@fragment
fn fs_gbuffer(
    in: Varyings,
    @builtin(front_facing) front_facing: bool,
    @builtin(primitive_index) primitive: u32,
) -> @location(0) vec4u {
    let base = material.base_color * in.color * textureSample(base_color_texture, base_color_sampler, in.uv);
    let surface = textureSample(metallic_roughness_texture, metallic_roughness_sampler, in.uv);
    if base.a < material.alpha_cutoff {
        discard;
    }
    let triangle = material.first_triangle + primitive;
    // Vertex normals that cancel leave nothing to interpolate: the face's own normal then.
    let has_normal = dot(in.normal, in.normal) > 1e-12;
    let normal = normalize(select(planes[triangle].xyz, in.normal, has_normal)) * select(-1.0, 1.0, front_facing);
    let metallic = saturate(material.metallic * surface.b);
    let roughness = saturate(material.roughness * surface.g);
    let factors = material_to_bits(saturate(base.rgb), metallic, roughness);
    return vec4u(unit_to_bits(normal), triangle + 1u, factors);
}

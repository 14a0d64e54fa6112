// What each pixel sees, packed in 16 bytes:
//   x  shading normal towards the viewer, octahedral 2 x 16 bits
//   y  index of the triangle + 1; 0 is the background
//   zw base colour, metallic and roughness: material_to_bits
// and in a texture of its own the terminator's offset.
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

struct Seen {
    @location(0) packed: vec4u,
    @location(1) terminator_offset: f32,
}

// How far along the shading normal shadows are looked for, so that facets do not shadow each other where light grazes:
// sum b_i |(p_i - P) . (n_i - m)| with m = sum b_i n_i. After Hanika, "Hacking the Shadow Terminator" (Ray Tracing Gems II,
// chapter 4); why not quite as he has it, see Surface::shadow_position of the reference.
fn terminator_offset(triangle: u32, position: vec3f) -> f32 {
    let corners = corners_of(triangle);
    let weights = max(weights_at(corners, position), vec3f(0.0));
    let n_a = normal_of(indices[3u * triangle]);
    let n_b = normal_of(indices[3u * triangle + 1u]);
    let n_c = normal_of(indices[3u * triangle + 2u]);
    let mean = mat3x3f(n_a, n_b, n_c) * weights;
    let bulges = vec3f(
        dot(corners.a - position, n_a - mean),
        dot(corners.b - position, n_b - mean),
        dot(corners.c - position, n_c - mean),
    );
    return dot(weights, abs(bulges));
}

@fragment
fn fs_gbuffer(
    in: Varyings,
    @builtin(front_facing) front_facing: bool,
    @builtin(primitive_index) primitive: u32,
) -> Seen {
    let base = material.base_color * in.color * textureSample(base_color_texture, base_color_sampler, in.uv);
    let surface = textureSample(metallic_roughness_texture, metallic_roughness_sampler, in.uv);
    if base.a < material.alpha_cutoff {
        discard;
    }
    let triangle = material.first_triangle + primitive;
    // Vertex normals that cancel leave nothing to interpolate: the face's own normal then.
    let has_normal = dot(in.normal, in.normal) > 1e-12;
    let side = select(-1.0, 1.0, front_facing);
    let normal = normalize(select(planes[triangle].xyz, in.normal, has_normal)) * side;
    let metallic = saturate(material.metallic * surface.b);
    let roughness = saturate(material.roughness * surface.g);
    let factors = material_to_bits(saturate(base.rgb), metallic, roughness);
    let ray = ray_through(vec2u(in.clip.xy));
    let position = ray.origin + depth_on(planes[triangle], ray, in.clip.z) * ray.direction;
    let offset = terminator_offset(triangle, position);
    return Seen(vec4u(unit_to_bits(normal), triangle + 1u, factors), offset);
}

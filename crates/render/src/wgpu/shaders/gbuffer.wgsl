// The surface of each pixel, packed in 16 bytes:
//   x  shading normal towards the viewer, octahedral 2 x 16 bits
//   y  index of the triangle + 1; 0 is the background
//   zw base color, metallic and roughness: material_to_bits
// The terminator offset has a texture of its own. The position is not stored: surface.wgsl intersects the pixel's ray
// with the plane of its triangle, which is more exact than any depth buffer and gives the geometric normal as well.

// Features of materials, each set a pipeline of its own: a color texture, a metallic-roughness texture, and an alpha
// test.
override is_colored: bool;
override is_shiny: bool;
override is_tested: bool;

struct Corner {
    @builtin(position) clip: vec4f,
    // Index in `planes` of the draw's first triangle, from the instance index: `primitive_index` restarts with each
    // draw, and one material may take several draws.
    @location(0) @interpolate(flat, either) first_triangle: u32,
}

@vertex
fn vs_gbuffer(@location(0) position: vec3f, @builtin(instance_index) first_triangle: u32) -> Corner {
    return Corner(view.clip_from_scene * vec4f(position, 1.0), first_triangle);
}

struct Seen {
    @location(0) packed: vec4u,
    @location(1) terminator_offset: f32,
    // Depth on the triangle's plane. The rasterizer interpolates its own from the corner of the target. Of two
    // coincident surfaces, such as a carpet and its floor, a different one would be visible in each tile, in blocks.
    @builtin(frag_depth) z: f32,
}

// Vertex attributes interpolated at a point of a triangle. The rasterizer interpolates from the corner of its target,
// so tiles would differ in the last bits.
struct Interpolated {
    normal: vec3f,
    uv: vec2f,
    // uv on the triangle's plane, extrapolated outside of the triangle.
    plane_uv: vec2f,
    color: vec4f,
    // Distance of the shadow test along the shading normal, so that facets do not shadow each other where light grazes:
    // sum b_i |(p_i - P) . (n_i - m)| with m = sum b_i n_i. After Hanika, "Hacking the Shadow Terminator" (Ray Tracing
    // Gems II, chapter 4). Surface::shadow_position of the reference explains the difference.
    terminator_offset: f32,
}

fn color_of(vertex: u32) -> vec4f {
    let first = ATTRIBUTES * vertex + 5u;
    return vec4f(attributes[first], attributes[first + 1u], attributes[first + 2u], attributes[first + 3u]);
}

fn uv_of(vertex: u32) -> vec2f {
    let first = ATTRIBUTES * vertex + 3u;
    return vec2f(attributes[first], attributes[first + 1u]);
}

fn interpolated(triangle: u32, position: vec3f) -> Interpolated {
    let vertices = vec3u(indices[3u * triangle], indices[3u * triangle + 1u], indices[3u * triangle + 2u]);
    let corners = corners_of(triangle);
    let on_plane = weights_at(corners, position);
    let inside = max(on_plane, vec3f(0.0));
    // A triangle too small to resolve gets equal weights.
    let sum = inside.x + inside.y + inside.z;
    let weights = select(vec3f(1.0 / 3.0), inside / max(sum, 1e-37), sum > 0.0);
    let n_a = normal_of(vertices.x);
    let n_b = normal_of(vertices.y);
    let n_c = normal_of(vertices.z);
    let normal = mat3x3f(n_a, n_b, n_c) * weights;
    let uvs = mat3x2f(uv_of(vertices.x), uv_of(vertices.y), uv_of(vertices.z));
    let color = mat3x4f(color_of(vertices.x), color_of(vertices.y), color_of(vertices.z)) * weights;
    let bulges = vec3f(
        dot(corners.a - position, n_a - normal),
        dot(corners.b - position, n_b - normal),
        dot(corners.c - position, n_c - normal),
    );
    return Interpolated(normal, uvs * weights, uvs * on_plane, color, dot(weights, abs(bulges)));
}

@fragment
fn fs_gbuffer(
    corner: Corner,
    @builtin(front_facing) front_facing: bool,
    @builtin(primitive_index) primitive: u32,
) -> Seen {
    let triangle = corner.first_triangle + primitive;
    let ray = ray_through(vec2u(corner.clip.xy));
    let depth = depth_on(planes[triangle], ray, corner.clip.z);
    let here = interpolated(triangle, ray.origin + depth * ray.direction);
    let uv_dx = dpdx(here.plane_uv);
    let uv_dy = dpdy(here.plane_uv);
    let factors = material.base_color * here.color;
    var is_there = true;
    if is_tested {
        // Sampled at full size, regardless of the pixel's footprint. Then the share of pixels that pass equals the
        // share of the texture's points.
        let alpha = textureSampleLevel(base_color_texture, base_color_sampler, here.uv, 0.0).a;
        is_there = factors.a * alpha >= material.alpha_cutoff;
    }
    if !is_there {
        discard;
    }
    var texel = vec4f(1.0);
    var shine = vec4f(1.0);
    if is_colored & is_there {
        texel = textureSampleGrad(base_color_texture, base_color_sampler, here.uv, uv_dx, uv_dy);
    }
    if is_shiny & is_there {
        shine = textureSampleGrad(metallic_roughness_texture, metallic_roughness_sampler, here.uv, uv_dx, uv_dy);
    }
    // Vertex normals that cancel leave nothing to interpolate, so the face normal is used.
    let has_normal = dot(here.normal, here.normal) > 1e-12;
    let side = select(-1.0, 1.0, front_facing);
    let normal = normalize(select(planes[triangle].xyz, here.normal, has_normal)) * side;
    let base_color = saturate(factors.rgb * texel.rgb);
    let metallic = saturate(material.metallic * shine.b);
    let roughness = saturate(material.roughness * shine.g);
    let packed = vec4u(unit_to_bits(normal), triangle + 1u, material_to_bits(base_color, metallic, roughness));
    return Seen(packed, here.terminator_offset, z_at(depth, corner.clip.z));
}

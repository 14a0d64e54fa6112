// Which of the scene's triangles count for a light that has links; no_links.wgsl is for others.

// A bit a triangle, 32 of them a texel, row after row: whether the light shows on it, and whether it throws shadows.
@group(3) @binding(0) var links: texture_2d<u32>;

fn link_bits(triangle: u32) -> vec2u {
    let width = textureDimensions(links).x;
    let word = triangle / 32u;
    return (textureLoad(links, vec2u(word % width, word / width), 0).xy >> vec2u(triangle % 32u)) & vec2u(1u);
}

fn is_lit(triangle: u32) -> bool {
    return link_bits(triangle).x != 0u;
}

fn throws_shadow(triangle: u32) -> bool {
    return link_bits(triangle).y != 0u;
}

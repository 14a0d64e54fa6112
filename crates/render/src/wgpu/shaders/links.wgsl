// Triangles selected by a light's links; no_links.wgsl is for lights without links.

// One bit per triangle, 32 per texel, row after row: set if the light lights it, and if it casts shadows.
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

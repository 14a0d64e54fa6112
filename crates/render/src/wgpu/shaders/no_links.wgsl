// All of the scene's triangles count for the light.

fn is_lit(triangle: u32) -> bool {
    return true;
}

fn throws_shadow(triangle: u32) -> bool {
    return true;
}

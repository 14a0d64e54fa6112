// Pictures beyond their edges.

// Texels that indices along one axis stand for: 0 repeats, 1 mirrors, 2 goes on with the edge. In floats, which are exact
// here: dividing integers is slow.
fn wrapped(x: vec2f, size: f32, wrap: u32) -> vec2u {
    let period = select(size, 2.0 * size, wrap == 1u);
    let inside = x - period * floor((x + 0.5) / period);
    let repeated = select(inside, min(inside, period - 1.0 - inside), wrap == 1u);
    return vec2u(clamp(select(repeated, x, wrap == 2u), vec2f(0.0), vec2f(size - 1.0)));
}

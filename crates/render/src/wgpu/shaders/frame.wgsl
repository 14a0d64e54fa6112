// The frame across a curve; twin of `light`'s frame.rs. Follows curve.wgsl.

// Returns w_hat from `up`, or from the axis that is least aligned with the tangent if `up` is parallel to it.
fn perpendicular_up(up: vec3f, u_hat: vec3f) -> vec3f {
    let perp = up - u_hat * dot(up, u_hat);
    if dot(perp, perp) >= 1e-12 {
        // Repeated, because the component that rounding left along `u_hat` is large relative to a small `perp`.
        let unit = normalize(perp);
        return normalize(unit - u_hat * dot(unit, u_hat));
    }
    let m = abs(u_hat);
    var axis = vec3f(0.0, 0.0, 1.0);
    if m.x <= m.y && m.x <= m.z {
        axis = vec3f(1.0, 0.0, 0.0);
    } else if m.y <= m.z {
        axis = vec3f(0.0, 1.0, 0.0);
    }
    return normalize(axis - u_hat * dot(axis, u_hat));
}

// Returns v_hat and w_hat, as the columns of a matrix: rotation-minimizing, or oriented by `up` everywhere.
fn cross_section(c: Curve, u_hat: vec3f, frame_up: bool, up: vec3f) -> mat2x3f {
    let w_hat = perpendicular_up(up, u_hat);
    let v_hat = cross(w_hat, u_hat);
    let minimizing = curve_rotation_minimizing(c, u_hat);
    return mat2x3f(select(minimizing[0], v_hat, frame_up), select(minimizing[1], w_hat, frame_up));
}

// The faces of a spotlight's map, each a perspective picture. A constant precedes this file:
//   SHADOW_CUBE  bool  the front of a cube around the light's axis, +x, -x, +y and -y in that order; else one face that
//                      contains the whole cone

// Returns the face that contains a position in light space.
fn face_of(position: vec3f) -> u32 {
    if !SHADOW_CUBE {
        return 0u;
    }
    let aside = abs(position.xy);
    let along_x = aside.x >= aside.y;
    let x_face = select(2u, 1u, position.x > 0.0);
    let y_face = select(4u, 3u, position.y > 0.0);
    return select(select(y_face, x_face, along_x), 0u, -position.z >= max(aside.x, aside.y));
}

// Returns a vector in the axes of a face: right, up and ahead. No angle changes; half of the faces are mirrored.
fn on_face(face: u32, v: vec3f) -> vec3f {
    if !SHADOW_CUBE {
        return vec3f(v.xy, -v.z);
    }
    let along_x = face == 1u || face == 2u;
    let ahead = select(v.y, v.x, along_x) * select(1.0, -1.0, face == 2u || face == 4u);
    let aside = vec3f(select(v.x, v.y, along_x), -v.z, ahead);
    return select(aside, vec3f(v.xy, -v.z), face == 0u);
}

// Returns the center and 1 / half size of the drawn part of a face, as slopes. Selected, not indexed: a software driver
// gathers one number after another.
fn fit_of(face: u32) -> vec4f {
    var fit = spot.fits[0];
    if SHADOW_CUBE {
        fit = select(fit, spot.fits[1], face == 1u);
        fit = select(fit, spot.fits[2], face == 2u);
        fit = select(fit, spot.fits[3], face == 3u);
        fit = select(fit, spot.fits[4], face == 4u);
    }
    return fit;
}

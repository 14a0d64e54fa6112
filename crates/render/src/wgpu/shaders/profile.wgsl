// Falloff of light along its path; twin of `light`'s profile/. Functions of the coordinates alone, for lights of every
// shape. Constants precede this file:
//   PROFILE       u32   curve of the falloff across the light
//   SUPERELLIPSE  bool  the outline is a superellipse, else a circle
//   RADIAL        bool  the edge is farther out on one side than on another
//   CUT           bool  the light begins or ends somewhere along its path

// Coordinates of a point in a light of any shape.
struct LightCoords {
    t: f32,
    // Across the light, in radii.
    vw: vec2f,
    // Length of the path from the source, in world units; 0 if nothing depends on it.
    s: f32,
    // Unit vector from the point to the origin of its light.
    direction: vec3f,
}

struct LightProfile {
    // Factor of all emission.
    tint: vec3f,
    // Light falls off no further nearer to its source.
    least_distance: f32,
    // Irradiance falls as 1 / (x + y s + z s^2).
    decay: vec3f,
    // The profile: see light::CrossFalloff.
    profile_power: f32,
    // Share of the light that arrives in shadow.
    shadow_color: vec3f,
    tan2_outer: f32,
    // Factors of scattered and mirrored light.
    lobes: vec2f,
    edge: f32,
    inverse_span: f32,
    // Cut-on and cut-off: see light::DistanceRamps.
    cut_starts: vec2f,
    cut_inverse_widths: vec2f,
    // The outline: see light::SectionOutline.
    section_scale: vec2f,
    section_power: f32,
    // Position of the edge around the light: degrees, shares at both ends of a piece, 1 over its length. See
    // light::LinearPiece.
    radial: array<vec4f, RADIAL_PIECES>,
}

const RADIAL_PIECES = 17u;

const PROFILE_SMOOTH = 0u;
const PROFILE_LINEAR = 1u;
const PROFILE_POWER = 2u;
const PROFILE_COSINE = 3u;

// Largest emission that stays finite through decay and the BRDF.
const MAX_EMISSION = 1e15;

// Largest factor of decay that stays finite through the BRDF; the factor at the source is infinite.
const MAX_DECAY = 1e15;

// Returns the irradiance on a surface perpendicular to the light, without visibility and `tint`. Emission is limited to
// finite results.
fn light_profile_irradiance(f: LightProfile, emission: vec3f, place: LightCoords) -> vec3f {
    let along = distance_ramps_at(f, place.s) * decay_at(f, max(place.s, f.least_distance));
    return min(emission, vec3f(MAX_EMISSION)) * (light_profile_across(f, place.vw) * along);
}

// Returns the share of the light that arrives if the share `visibility` of it is not blocked, linear RGB.
fn light_profile_arriving(f: LightProfile, visibility: f32) -> vec3f {
    return mix(f.shadow_color, vec3f(1.0), visibility);
}

// Returns the falloff across the light: zero outside of an outline at which the light does not end by itself.
fn light_profile_across(f: LightProfile, vw: vec2f) -> f32 {
    let share = edge_outline_share(f, vw);
    let rho2 = section_outline_rho2(f, vw) / (share * share);
    let is_outside = (SUPERELLIPSE || RADIAL) && rho2 > 1.0;
    return select(cross_falloff_at(f, rho2), 0.0, is_outside);
}

// Returns the square of the distance from the axis, as a share of the distance to the outline: 1 on the outline.
fn section_outline_rho2(f: LightProfile, vw: vec2f) -> f32 {
    if !SUPERELLIPSE {
        return dot(vw, vw);
    }
    let extents = abs(vw) * f.section_scale;
    let most = max(extents.x, extents.y);
    let share = min(extents.x, extents.y) / max(most, 1e-37);
    let rho = most * pow(1.0 + pow(share, f.section_power), 1.0 / f.section_power);
    return rho * rho;
}

// Returns the share of the distance to the outline at which the light has its edge, in the direction of `vw`.
fn edge_outline_share(f: LightProfile, vw: vec2f) -> f32 {
    if !RADIAL {
        return 1.0;
    }
    let degrees = angle_around(vw);
    var share = 1.0;
    for (var i = 0u; i < RADIAL_PIECES; i++) {
        let piece = f.radial[i];
        let there = mix(piece.y, piece.z, saturate((degrees - piece.x) * piece.w));
        share = select(share, there, degrees >= piece.x);
    }
    return share;
}

// Degrees from V, the left seen along the light, towards W, its top: 0 to 360. A GPU's own arc tangent may be wrong by
// 4096 ulp. This one, the polynomial in z = x^2 with the least largest relative error from 0 to 1, is wrong by 2e-8 and
// its roundings.
fn angle_around(vw: vec2f) -> f32 {
    let extents = abs(vw);
    let x = min(extents.x, extents.y) / max(max(extents.x, extents.y), 1e-37);
    let z = x * x;
    var p = 0.00284988687;
    p = p * z - 0.0160686152;
    p = p * z + 0.0426914918;
    p = p * z - 0.0750429169;
    p = p * z + 0.106409324;
    p = p * z - 0.142036440;
    p = p * z + 0.199926193;
    p = p * z - 0.333330733;
    p = p * z + 0.999999985;
    var degrees_around = degrees(x * p);
    degrees_around = select(degrees_around, 90.0 - degrees_around, extents.y > extents.x);
    degrees_around = select(degrees_around, 180.0 - degrees_around, vw.x < 0.0);
    return select(degrees_around, 360.0 - degrees_around, vw.y < 0.0);
}

// Returns the falloff in the cosine of the angle that rho = |(v, w)| stands for, from 1 - cos as a share of that at the
// edge; or in rho itself.
fn cross_falloff_at(f: LightProfile, rho2: f32) -> f32 {
    if PROFILE == PROFILE_COSINE {
        return pow(1.0 + rho2 * f.tan2_outer, -0.5 * f.profile_power);
    }
    var share = sqrt(rho2);
    if PROFILE != PROFILE_LINEAR {
        share = rho2 * f.edge / secants(rho2 * f.tan2_outer);
    }
    let s = saturate((1.0 - share) * f.inverse_span);
    var value = s;
    if PROFILE == PROFILE_SMOOTH {
        value = s * s * (3.0 - 2.0 * s);
    }
    if PROFILE == PROFILE_POWER {
        value = pow(s, f.profile_power);
    }
    return select(value, 1.0, f.inverse_span == 0.0);
}

fn secants(tan2: f32) -> f32 {
    let h = sqrt(1.0 + tan2);
    return h * (1.0 + h);
}

fn distance_ramps_at(f: LightProfile, s: f32) -> f32 {
    if !CUT {
        return 1.0;
    }
    let x = saturate(max(vec2f(s) - f.cut_starts, vec2f(0.0)) * f.cut_inverse_widths);
    let ramps = x * x * (3.0 - 2.0 * x);
    return ramps.x * (1.0 - ramps.y);
}

fn decay_at(f: LightProfile, s: f32) -> f32 {
    return 1.0 / max(dot(f.decay, vec3f(1.0, s, s * s)), 1.0 / MAX_DECAY);
}

// What becomes of light on its way, as `light` has it in filter.rs: functions of the place alone, for lights of every
// shape.

// Where a point lies in a light, whatever its shape.
struct Place {
    t: f32,
    // Across the light, in radii.
    vw: vec2f,
    // Length of the way from the source, in world units; 0 where the light does not fall off with it.
    s: f32,
    // Unit vector from the point to where its light comes from.
    direction: vec3f,
}

struct LightFilter {
    // Irradiance falls as 1 / (x + y s + z s^2).
    decay: vec3f,
    // Light falls off no further nearer to its source.
    least_distance: f32,
    // The profile: see light::Profile.
    tan2_outer: f32,
    edge: f32,
    inverse_span: f32,
    // Stops by which all of the light is brightened.
    exposure: f32,
}

// Largest emission that stays finite through decay and the BRDF.
const MAX_EMISSION = 1e15;

// Largest factor of decay that stays finite through the BRDF: the source itself has none that is finite.
const MAX_DECAY = 1e15;

// Irradiance on a surface square to the light, without visibility. What is emitted is held to what stays finite.
fn irradiance(f: LightFilter, emission: vec3f, place: Place) -> vec3f {
    let s = max(place.s, f.least_distance);
    let exposed = min(emission * exp2(f.exposure), vec3f(MAX_EMISSION));
    return exposed * (profile_at(f, dot(place.vw, place.vw)) * decay_at(f, s));
}

// An S-curve in the cosine of the angle that rho = |(v, w)| stands for, by 1 - cos as a share of that at the edge.
fn profile_at(f: LightFilter, rho2: f32) -> f32 {
    let share = rho2 * f.edge / secants(rho2 * f.tan2_outer);
    let s = saturate((1.0 - share) * f.inverse_span);
    return select(s * s * (3.0 - 2.0 * s), 1.0, f.inverse_span == 0.0);
}

fn secants(tan2: f32) -> f32 {
    let h = sqrt(1.0 + tan2);
    return h * (1.0 + h);
}

fn decay_at(f: LightFilter, s: f32) -> f32 {
    return 1.0 / max(dot(f.decay, vec3f(1.0, s, s * s)), 1.0 / MAX_DECAY);
}

// glTF 2.0 appendix B: Lambert under GGX (Walter et al. 2007) with the height-correlated Smith visibility
// (Heitz 2014) and Schlick's Fresnel term.

const PI: f32 = 3.14159265358979;
// Smallest GGX alpha. A point light mirrored in a perfectly smooth surface has infinite radiance, and the stored
// normals resolve 2e-5 rad: this width keeps highlights finite, and a hundred times wider than the steps of the
// normals.
const MIN_ALPHA: f32 = 0.002;

// f(l, v) max(0, n.l), by lobe.
struct Lobes {
    diffuse: vec3f,
    specular: vec3f,
}

// Returns the radiance towards the eye, scattered and mirrored, from light of unit irradiance that arrives along
// `to_light`. The irradiance is on a plane perpendicular to `to_light`.
fn reflected(surface: Surface, to_light: vec3f) -> Lobes {
    let n = surface.normal;
    let n_l = dot(n, to_light);
    if n_l <= 0.0 {
        return Lobes();
    }
    // Shading normals at a silhouette may point away from the viewer.
    let n_v = max(dot(n, surface.to_eye), 1e-4);
    let half_sum = to_light + surface.to_eye;
    let h = half_sum * inverseSqrt(max(dot(half_sum, half_sum), 1e-12));
    let v_h = saturate(dot(surface.to_eye, h));

    let alpha = max(surface.roughness * surface.roughness, MIN_ALPHA);
    let a2 = alpha * alpha;
    // 1 - (n.h)^2 as |n x h|^2, which does not cancel at the peak.
    let across = cross(n, h);
    let sin2 = min(dot(across, across), 1.0);
    let slope = sin2 + a2 * (1.0 - sin2);
    let distribution = select(0.0, a2 / (PI * slope * slope), dot(n, h) > 0.0);
    let visibility = 0.5 / (n_l * sqrt(n_v * n_v * (1.0 - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0 - a2) + a2));

    let f0 = mix(vec3f(0.04), surface.base_color, surface.metallic);
    let grazing = 1.0 - v_h;
    let fresnel = f0 + (1.0 - f0) * (grazing * grazing * grazing * grazing * grazing);
    let diffuse = (1.0 - fresnel) * (1.0 - surface.metallic) * surface.base_color / PI;
    return Lobes(diffuse * n_l, fresnel * (distribution * visibility * n_l));
}

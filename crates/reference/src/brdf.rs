//! BRDF of surfaces (glTF 2.0, appendix B).

use std::f64::consts::PI;

use glam::DVec3;

use crate::ShadedPoint;

/// Minimum GGX alpha. At 0 the mirror image of a point light would have infinite radiance. Every backend uses
/// this value, as part of the meaning of a material.
const MIN_ALPHA: f64 = 0.002;

/// Computes `f(l, v) max(0, n.l)`: the radiance towards the viewer per unit irradiance perpendicular to
/// `to_light`, linear RGB (Real-Time Rendering, eqs 7.20 and 7.21). The factors scale the diffuse and the
/// specular lobe.
///
/// The diffuse lobe is Lambert's. The specular lobe is GGX (Walter et al. 2007) with height-correlated Smith
/// visibility (Heitz 2014) and Schlick's Fresnel term.
pub fn evaluate_brdf(surface: &ShadedPoint, to_light: DVec3, [scattered, mirrored]: [f64; 2]) -> DVec3 {
    let n = surface.normal;
    let n_l = n.dot(to_light);
    if n_l <= 0.0 {
        return DVec3::ZERO;
    }
    // At a silhouette the shading normal may face away from the viewer.
    let n_v = n.dot(surface.to_eye).max(1e-4);
    let half_sum = to_light + surface.to_eye;
    let h = half_sum / half_sum.length_squared().max(1e-12).sqrt();
    let v_h = surface.to_eye.dot(h).clamp(0.0, 1.0);

    let alpha = (surface.roughness * surface.roughness).max(MIN_ALPHA);
    let a2 = alpha * alpha;
    // Computes 1 - (n.h)^2 as |n x h|^2, which does not cancel at the peak.
    let sin2 = n.cross(h).length_squared().min(1.0);
    let slope = sin2 + a2 * (1.0 - sin2);
    let distribution = if n.dot(h) > 0.0 { a2 / (PI * slope * slope) } else { 0.0 };
    let smith = |cosine: f64| (cosine * cosine * (1.0 - a2) + a2).sqrt();
    let visibility = 0.5 / (n_l * smith(n_v) + n_v * smith(n_l));

    let f0 = DVec3::splat(0.04).lerp(surface.base_color, surface.metallic);
    let grazing = 1.0 - v_h;
    let squared = grazing * grazing;
    let fresnel = f0 + (DVec3::ONE - f0) * (grazing * (squared * squared));
    let diffuse = (DVec3::ONE - fresnel) * (1.0 - surface.metallic) * surface.base_color / PI;
    (diffuse * scattered + fresnel * distribution * visibility * mirrored) * n_l
}

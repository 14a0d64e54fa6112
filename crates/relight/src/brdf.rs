//! BRDF of surfaces: glTF 2.0 appendix B, as in `brdf.wgsl`. Lambert under GGX (Walter et al. 2007) with the
//! height-correlated Smith visibility (Heitz 2014) and Schlick's Fresnel term.

use std::f32::consts::FRAC_1_PI;

use light::Lanes;

use crate::lanes::{F32s, Vec3s};
use crate::surfaces::SurfaceLanes;

/// Least width of a highlight. `brdf.wgsl` has the reason.
const MIN_ALPHA: f32 = 0.002;

/// Diffuse and specular part of `f(l, v) max(0, n.l)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lobes {
    pub diffuse: Vec3s,
    pub specular: Vec3s,
}

/// Computes the radiance to the eye for unit irradiance orthogonal to `to_light`, diffuse and specular; 0 from behind.
#[inline(always)]
pub(crate) fn evaluate_brdf(surface: &SurfaceLanes, to_light: Vec3s) -> Lobes {
    let (zero, one, half) = (F32s::splat(0.0), F32s::splat(1.0), F32s::splat(0.5));
    let n = surface.normal;
    let n_l = F32s::dot(n, to_light);
    // Shading normals at a silhouette may lean away from the viewer.
    let n_v = F32s::dot(n, surface.to_eye).most(F32s::splat(1e-4));
    let half_sum = to_light + surface.to_eye;
    let h = half_sum * (one / F32s::dot(half_sum, half_sum).most(F32s::splat(1e-12)).sqrt());
    let v_h = F32s::dot(surface.to_eye, h).within(zero, one);

    let alpha = (surface.roughness * surface.roughness).most(F32s::splat(MIN_ALPHA));
    let a2 = alpha * alpha;
    // 1 - (n.h)^2 as |n x h|^2, which does not cancel at the peak.
    let across = F32s::cross(n, h);
    let sin2 = F32s::dot(across, across).least(one);
    let slope = sin2 + a2 * (one - sin2);
    let peak = a2 * F32s::splat(FRAC_1_PI) / (slope * slope);
    let distribution = F32s::select(F32s::dot(n, h).gt(zero), peak, zero);
    let lit = n_l.gt(zero);
    let n_l = F32s::select(lit, n_l, one);
    let masked = n_l * (n_v * n_v * (one - a2) + a2).sqrt() + n_v * (n_l * n_l * (one - a2) + a2).sqrt();
    let visibility = half / masked;

    let dielectric = Vec3s::splat([0.04; 3]);
    let f0 = dielectric + (surface.base_color - dielectric) * surface.metallic;
    let grazing = one - v_h;
    let grazing2 = grazing * grazing;
    let white = Vec3s::splat([1.0; 3]);
    let fresnel = f0 + (white - f0) * (grazing2 * grazing2 * grazing);
    let cosine = F32s::select(lit, n_l, zero);
    let scattered = (one - surface.metallic) * F32s::splat(FRAC_1_PI) * cosine;
    Lobes {
        diffuse: (white - fresnel) * surface.base_color * scattered,
        specular: fresnel * (distribution * visibility * cosine),
    }
}

#[cfg(test)]
mod tests;

//! BRDF against glTF 2.0 appendix B in f64, as its sources write it. The specular lobe has the distribution of normals,
//! masking and shadowing by Smith's Lambda, Schlick's Fresnel term and the cosine as separate factors.

use std::f64::consts::PI;

use glam::DVec3;

use super::{F32s, SurfaceLanes, Vec3s, evaluate_brdf};
use crate::lanes::LANES;

/// Largest relative error. Directions are unit to an ulp of 2^-24. The narrowness of the highlight, `tan^2 / alpha^2`,
/// changes by `2 / alpha` times that. Alpha is at least 0.09 here, and the lobe falls with the square: some 60
/// roundings, and as many again of factors and sums.
const TOLERANCE: f64 = 120.0 / 16_777_216.0;

/// Surface with a `normal`, seen from `to_eye`.
#[derive(Clone, Copy, Debug)]
struct Case {
    normal: DVec3,
    to_eye: DVec3,
    to_light: DVec3,
    base_color: DVec3,
    metallic: f64,
    roughness: f64,
}

/// Factor of the specular lobe, beside color.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Factor {
    Distribution,
    Masking,
    Fresnel,
    Cosine,
}

impl Case {
    /// Computes the diffuse and the specular lobe, the latter without the `dropped` factor of a deliberate fault.
    fn expected(&self, dropped: Option<Factor>) -> [DVec3; 2] {
        let Self { normal: n, to_eye: v, to_light: l, base_color, metallic, .. } = *self;
        let h = (v + l).normalize();
        let alpha = self.roughness * self.roughness;
        let tan2 = |cosine: f64| (1.0 - cosine * cosine) / (cosine * cosine);
        // Walter et al. 2007, eq. 33; Heitz 2014, eq. 72 and 99.
        let cos_h = n.dot(h);
        let spread = cos_h * cos_h * (alpha * alpha + tan2(cos_h));
        let distribution = alpha * alpha / (PI * spread * spread);
        let lambda = |cosine: f64| ((1.0 + alpha * alpha * tan2(cosine)).sqrt() - 1.0) / 2.0;
        let masking = 1.0 / (1.0 + lambda(n.dot(l)) + lambda(n.dot(v)));
        let f0 = DVec3::splat(0.04).lerp(base_color, metallic);
        let fresnel = f0 + (1.0 - f0) * libm::pow(1.0 - v.dot(h), 5.0);
        let cosine = n.dot(l);
        let of = |factor: Factor, value: f64| if dropped == Some(factor) { 1.0 } else { value };
        let color = if dropped == Some(Factor::Fresnel) { DVec3::ONE } else { fresnel };
        let mirrored = color
            * (of(Factor::Distribution, distribution) * of(Factor::Masking, masking) * of(Factor::Cosine, cosine)
                / (4.0 * n.dot(l) * n.dot(v)));
        [(1.0 - fresnel) * (1.0 - metallic) * base_color / PI * cosine, mirrored]
    }
}

/// Makes groups of sixteen unordered cases, from one sequence of powers of the plastic number.
fn cases() -> Vec<[Case; LANES]> {
    let number = |k: usize, factor: f64| (k as f64 * factor).fract();
    let direction = |k: usize, normal: DVec3| {
        let (turn, height) = (2.0 * PI * number(k, 0.819_172_5), 0.05 + 0.95 * number(k, 0.671_043_6));
        let (a, b) = normal.any_orthonormal_pair();
        let aside = (1.0 - height * height).sqrt();
        (a * (libm::cos(turn) * aside) + b * (libm::sin(turn) * aside) + normal * height).normalize()
    };
    let one = |k: usize| {
        let normal = DVec3::new(number(k, 0.754_878) - 0.5, number(k, 0.569_84) - 0.5, 0.3).normalize();
        Case {
            normal,
            to_eye: direction(k, normal),
            to_light: direction(7 * k + 3, normal),
            base_color: DVec3::new(number(k, 0.618_034), number(k, 0.414_214), number(k, 0.732_051)),
            metallic: number(k, 0.236_068),
            roughness: 0.3 + 0.7 * number(k, 0.302_776),
        }
    };
    (0..100).map(|group| std::array::from_fn(|lane| one(group * LANES + lane + 1))).collect()
}

fn in_lanes(cases: &[Case; LANES]) -> (SurfaceLanes, Vec3s) {
    let vectors = |of: fn(&Case) -> DVec3| {
        let axis = |k: usize| F32s(std::array::from_fn(|lane| of(&cases[lane])[k] as f32));
        Vec3s { x: axis(0), y: axis(1), z: axis(2) }
    };
    let numbers = |of: fn(&Case) -> f64| F32s(std::array::from_fn(|lane| of(&cases[lane]) as f32));
    let surface = SurfaceLanes {
        to_eye: vectors(|case| case.to_eye),
        base_color: vectors(|case| case.base_color),
        metallic: numbers(|case| case.metallic),
        roughness: numbers(|case| case.roughness),
        ..SurfaceLanes::facing(vectors(|case| case.normal))
    };
    (surface, vectors(|case| case.to_light))
}

/// Counts the cases whose reflection is off by more than the tolerance.
fn off(dropped: Option<Factor>) -> usize {
    let mut off = 0;
    for cases in cases() {
        let (surface, to_light) = in_lanes(&cases);
        let lobes = evaluate_brdf(&surface, to_light);
        for (lane, case) in cases.iter().enumerate() {
            let found = [lobes.diffuse, lobes.specular].map(|lobe| lobe.lane(lane).as_dvec3());
            let close =
                |(found, expected): (DVec3, DVec3)| (found - expected).abs().cmple(expected * TOLERANCE + 1e-9).all();
            off += usize::from(!found.into_iter().zip(case.expected(dropped)).all(close));
        }
    }
    off
}

#[test]
fn surfaces_reflect_what_the_formulas_say() {
    assert_eq!(off(None), 0);
}

#[test]
fn a_highlight_without_one_of_its_factors_is_seen() {
    for factor in [Factor::Distribution, Factor::Masking, Factor::Fresnel, Factor::Cosine] {
        let off = off(Some(factor));
        assert!(off > 1500, "without its {factor:?} a highlight is another in {off} of 1600 cases");
    }
}

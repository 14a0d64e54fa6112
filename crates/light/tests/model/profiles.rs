//! Profiles against the printed formulas, in f64.
//!
//! A value of size 1 after some ten roundings, each of half an ulp, has an error of at most 1e-14. The printed formulas
//! divide by the difference of two cosines and lose as many digits as cancel there, at most two for the angles here.

use glam::DVec3;
use light::parameters::{
    COLOR, COLOR_TEMPERATURE, CONE_ANGLE, CONE_SOFTNESS, CROSS_SECTION, CUT_OFF, CUT_ON, DECAY, DECAY_START,
    ENABLE_COLOR_TEMPERATURE, ENABLED, EXPOSURE, FAR_EDGE, INTENSITY, NEAR_EDGE, PROFILE, PROFILE_POWER,
    RADIAL_FALLOFF, SECTION_HEIGHT, SECTION_ROUNDNESS, SECTION_WIDTH,
};
use light::{
    CheckedLight, Cone, CrossSection, Decay, Light, LightProfile, MAX_KNOTS, PeriodicCurve, ProfileCurve,
    SectionOutline, bend, blackbody,
};

const POINTS: u32 = 1000;
const ROUNDING: f64 = 1e-12;

fn shares() -> impl Iterator<Item = f64> {
    (0..POINTS).map(|k| (f64::from(k) + 0.5) / f64::from(POINTS))
}

fn profile(light: &Light) -> LightProfile {
    LightProfile::of(light, 0.0)
}

/// Returns the largest difference of two functions over the angle from the axis to the edge.
fn apart(light: &Light, expected: impl Fn(f64) -> f64) -> f64 {
    let outer = light.get(CONE_ANGLE).to_radians();
    let profile = profile(light).profile;
    let off = |share: f64| {
        let angle = outer * share;
        let rho = angle.tan() / outer.tan();
        (profile.at(rho * rho) - expected(angle)).abs()
    };
    shares().map(off).fold(0.0, f64::max)
}

fn spots() -> impl Iterator<Item = Light> {
    let spot = |(angle, softness)| Light::spot().with(CONE_ANGLE, angle).with(CONE_SOFTNESS, softness);
    [(25.0, 0.2), (60.0, 1.0), (10.0, 0.5), (85.0, 0.7)].into_iter().map(spot)
}

/// Returns the profile `(cos theta_s - cos theta_u) / (cos theta_p - cos theta_u)` between the angles of penumbra and
/// umbra, 1 within, 0 beyond.
fn three_zones(light: &Light) -> impl Fn(f64) -> f64 {
    let umbra = light.get(CONE_ANGLE).to_radians();
    let penumbra = umbra * (1.0 - light.get(CONE_SOFTNESS));
    move |angle| match angle {
        angle if angle <= penumbra => 1.0,
        angle if angle >= umbra => 0.0,
        angle => (angle.cos() - umbra.cos()) / (penumbra.cos() - umbra.cos()),
    }
}

#[test]
fn the_smooth_profile_is_an_s_curve() {
    for light in spots() {
        let s = three_zones(&light);
        assert!(apart(&light, |angle| s(angle).powi(2) * (3.0 - 2.0 * s(angle))) < ROUNDING);
        // Deliberate fault that the check must detect: the three zones themselves.
        assert!(apart(&light, s) > 1e-2);
    }
}

#[test]
fn the_power_profile_is_equation_7_18() {
    for light in spots() {
        for power in [0.25, 1.0, 2.0, 17.5] {
            let light = light.clone().with(PROFILE, ProfileCurve::Power).with(PROFILE_POWER, power);
            let s = three_zones(&light);
            // A root of `s` amplifies the cancellation where `s` ends at 0.
            let tolerance = ROUNDING.powf(power.min(1.0)).max(ROUNDING);
            let off = apart(&light, |angle| s(angle).powf(power));
            assert!(off < tolerance, "{power}: {off:e}");
            assert!(apart(&light, |angle| s(angle).powf(power * 1.1)) > 1e-3);
        }
    }
}

#[test]
fn the_cosine_profile_is_equation_7_17() {
    for light in spots() {
        for power in [0.5, 1.0, 8.0, 100.0] {
            let light = light.clone().with(PROFILE, ProfileCurve::Cosine).with(PROFILE_POWER, power);
            let off = apart(&light, |angle| angle.cos().powf(power));
            assert!(off < ROUNDING, "{power}: {off:e}");
            // Deliberate fault that the check must detect: equation 7.18 from the axis on, which ends at 0.
            let umbra = light.get(CONE_ANGLE).to_radians().cos();
            assert!(apart(&light, |angle| ((angle.cos() - umbra) / (1.0 - umbra)).powf(power)) > 1e-2);
        }
    }
}

#[test]
fn the_linear_profile_falls_evenly_with_the_distance_from_the_axis() {
    for light in spots().map(|light| light.with(PROFILE, ProfileCurve::Linear)) {
        let outer = light.get(CONE_ANGLE).to_radians();
        let inner = (outer * (1.0 - light.get(CONE_SOFTNESS))).tan() / outer.tan();
        let line = |angle: f64| ((1.0 - angle.tan() / outer.tan()) / (1.0 - inner)).clamp(0.0, 1.0);
        assert!(apart(&light, line) < ROUNDING);
        assert!(apart(&light, three_zones(&light)) > 1e-3);
    }
}

/// Equal angles are a step for every curve. The narrowest cone keeps its shape.
#[test]
fn profiles_without_softness_are_steps() {
    for curve in [ProfileCurve::Smooth, ProfileCurve::Linear, ProfileCurve::Power] {
        for angle in [1e-100, 1e-6, 25.0, 89.9] {
            let step = Light::spot().with(CONE_ANGLE, angle).with(PROFILE, curve).with(CONE_SOFTNESS, 0.0);
            let hard = profile(&step).profile;
            assert!(shares().all(|rho| hard.at(rho * rho) == 1.0), "{curve:?} {angle}");
            let soft = profile(&step.with(CONE_SOFTNESS, 1e-15)).profile;
            assert!(shares().all(|rho| (0.0..=1.0).contains(&soft.at(rho * rho))), "{curve:?} {angle}");
        }
    }
}

fn section(width: f64, height: f64, roundness: f64) -> SectionOutline {
    let light = Light::spot().with(CROSS_SECTION, CrossSection::Superellipse);
    let light = light.with(SECTION_WIDTH, width).with(SECTION_HEIGHT, height);
    SectionOutline::of(&light.with(SECTION_ROUNDNESS, roundness))
}

/// Returns the points of `(|x| / a)^(2/d) + (|y| / b)^(2/d) = 1`, by its own parameter.
fn outline([a, b]: [f64; 2], roundness: f64) -> impl Iterator<Item = (f64, f64)> {
    shares().map(move |share| {
        let (sin, cos) = (share * std::f64::consts::TAU).sin_cos();
        let along = |x: f64, half: f64| half * x.signum() * x.abs().powf(roundness);
        (along(cos, a), along(sin, b))
    })
}

/// A superellipse inside the circle follows Barzel's formula. A larger one is scaled down until its farthest points are
/// on the circle.
#[test]
fn the_superellipse_is_barzels_and_stays_within_the_radius() {
    let mut shrunk = 0;
    for [a, b, roundness] in [
        [0.6, 0.3, 1.0],
        [1.0, 0.25, 1.0],
        [0.7, 0.7, 0.5],
        [1.0, 1.0, 0.5],
        [1.0, 0.5, 0.2],
        [0.5, 0.9, 0.05],
        [0.2, 0.2, 0.01],
    ] {
        let section = section(a, b, roundness);
        let farthest = outline([a, b], roundness).map(|(x, y)| x.hypot(y)).fold(0.0, f64::max);
        shrunk += usize::from(farthest > 1.0);
        // The outline is sampled in steps. Its corner near the circle may lie between two of them.
        let scale = 1.0 / farthest.max(1.0);
        let slack = if farthest > 1.0 { 2e-2 } else { 1e-9 };
        for (x, y) in outline([a, b], roundness) {
            let rho = section.rho2(x * scale, y * scale).sqrt();
            assert!((rho - 1.0).abs() < slack, "{a} {b} {roundness}: {rho} at ({x}, {y})");
            assert!((section.rho2(x * scale * 0.5, y * scale * 0.5).sqrt() / rho - 0.5).abs() < 1e-12);
        }
        // The outline touches the circle and does not cross it.
        let reach = |angle: f64| section.rho2(angle.cos(), angle.sin()).sqrt().recip();
        let reach = (0..100_000).map(|k| reach(f64::from(k) * 1e-5 * std::f64::consts::TAU)).fold(0.0, f64::max);
        assert!(reach <= 1.0 + 1e-12, "{a} {b} {roundness}: reaches {reach}");
        assert!(farthest < 1.0 || reach > 1.0 - 1e-3, "{a} {b} {roundness}: reaches only {reach}");
        // Deliberate fault that the check must detect: an ellipse.
        let ellipse = |(x, y): (f64, f64)| ((x / a).powi(2) + (y / b).powi(2)).sqrt();
        let off = outline([a, b], roundness).map(|point| (ellipse(point) - 1.0).abs()).fold(0.0, f64::max);
        assert_eq!(off > 1e-2, roundness < 1.0, "{off}");
    }
    assert!((2..6).contains(&shrunk), "{shrunk}");
}

/// Without roundness the section is a rectangle with its corners.
#[test]
fn a_section_without_roundness_is_a_rectangle() {
    let section = section(0.4, 0.2, 0.0);
    for (x, y) in shares().zip(shares().map(|share| (share * 7.3).fract())) {
        let rho = (x / 0.4).max(y / 0.2);
        assert!((section.rho2(x, y).sqrt() - rho).abs() < 1e-14 * rho, "({x}, {y})");
    }
    assert!((section.rho2(0.4, 0.2) - 1.0_f64).abs() < 1e-14);
}

/// The share scales the profile's edge. It is linear from one angle to the next, and around from the last to the first,
/// from the light's left over its top.
///
/// Rules: CURVE-1
#[test]
fn the_radial_falloff_scales_the_edge() {
    let around = |knots: &[[f64; 2]], degrees: f64| {
        let turned = |turns: f64| knots.iter().map(move |[at, share]| [at + 360.0 * turns, *share]);
        let line: Vec<_> = turned(-1.0).chain(turned(0.0)).chain(turned(1.0)).collect();
        let between = line.windows(2).find(|pair| (pair[0][0]..=pair[1][0]).contains(&degrees));
        let [[a, from], [b, to]] = between.expect("three turns hold it")[..] else { unreachable!() };
        from + (to - from) * (degrees - a) / (b - a)
    };
    let lists: [&[[f64; 2]]; 4] = [
        &[[40.0, 0.5]],
        &[[0.0, 1.0], [180.0, 0.25]],
        &[[30.0, 0.9], [31.0, 0.2], [300.0, 0.6]],
        &std::array::from_fn::<_, MAX_KNOTS, _>(|k| [22.5 * k as f64 + 3.0, if k % 2 == 0 { 1.0 } else { 0.4 }]),
    ];
    for knots in lists {
        let spot = Light::spot().with(CONE_SOFTNESS, 1.0).with(PROFILE, ProfileCurve::Linear);
        let cone = |curve| Cone::new(&spot.clone().with(RADIAL_FALLOFF, curve)).expect("valid");
        let curved = cone(PeriodicCurve::new(knots.to_vec()));
        let mut turned_off = 0.0_f64;
        for (degrees, rho) in shares().map(|share| 360.0 * share).zip(shares().map(|share| (share * 7.3).fract())) {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let across = rho * 25f64.to_radians().tan();
            let coords = curved.locate(DVec3::new(-across * cos, across * sin, -1.0)).expect("in the cone");
            let given = curved.irradiance(&coords).x * coords.s * coords.s;
            let expected = |share: f64| (1.0 - rho / share).max(0.0);
            let off = (given - expected(around(knots, degrees))).abs();
            // The profile's slope per degree is at most 0.7, and an angle is exact to a few ulp of 360.
            assert!(off < ROUNDING, "{knots:?} {degrees} {rho}: {off:e}");
            // Deliberate fault that the check must detect: the opposite direction around.
            turned_off = turned_off.max((given - expected(around(knots, 360.0 - degrees))).abs());
        }
        assert_eq!(turned_off > 0.1, knots.len() > 2, "{turned_off}");
    }
    // A step stays a step: no light is left past its edge.
    let hard = Light::spot().with(CONE_SOFTNESS, 0.0).with(RADIAL_FALLOFF, PeriodicCurve::new(vec![[0.0, 0.5]]));
    let cone = Cone::new(&hard).expect("valid");
    let at = |rho: f64| {
        let coords = cone.locate(DVec3::new(0.0, rho * 25f64.to_radians().tan(), -1.0)).expect("in the cone");
        cone.irradiance(&coords).x > 0.0
    };
    assert_eq!([0.0, 0.49, 0.51, 0.99].map(at), [true, true, false, false]);
}

#[test]
fn light_decays_from_where_its_decay_starts() {
    let powers = [(Decay::None, 0), (Decay::Linear, 1), (Decay::InverseSquare, 2)];
    for (decay, power) in powers {
        for start in [0.0, 0.5, 3.0] {
            let light = Light::spot().with(DECAY, decay).with(DECAY_START, start).with(CONE_SOFTNESS, 0.0);
            let cone = Cone::new(&light).expect("valid");
            for s in shares().map(|share| 10.0 * share) {
                let coords = cone.locate(DVec3::new(0.0, 0.0, -s)).expect("on the axis");
                let expected = s.max(start).powi(-power);
                assert!((cone.irradiance(&coords).x / expected - 1.0).abs() < ROUNDING, "{decay:?} {start} {s}");
                // Deliberate fault that the check must detect: a decay that begins at the start, at 1.
                let shifted = (1.0 + (s - start).max(0.0)).powi(-power);
                assert!(power == 0 || (shifted / expected - 1.0).abs() > 1e-6 || (start - s).abs() > 0.2);
            }
        }
    }
}

/// `smoothstep(on - near, on, s) (1 - smoothstep(off, off + far, s))`; without edges, all light between the two.
#[test]
fn light_is_cut_on_and_off() {
    let smoothstep = |a: f64, b: f64, s: f64| {
        let x = ((s - a) / (b - a)).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    let light = Light::spot().with(CUT_ON, Some(3.0)).with(NEAR_EDGE, 2.0);
    let both = profile(&light.with(CUT_OFF, Some(6.0)).with(FAR_EDGE, 1.5)).distance_ramps;
    let hard = profile(&Light::spot().with(CUT_ON, Some(3.0)).with(CUT_OFF, Some(6.0))).distance_ramps;
    let off_alone = profile(&Light::spot().with(CUT_OFF, Some(6.0))).distance_ramps;
    let mut differs = 0.0_f64;
    for s in shares().map(|share| 10.0 * share) {
        let expected = smoothstep(1.0, 3.0, s) * (1.0 - smoothstep(6.0, 7.5, s));
        assert!((both.at(s) - expected).abs() < ROUNDING, "{s}");
        differs = differs.max((both.at(s) - smoothstep(1.0, 3.0, s)).abs());
        assert_eq!(hard.at(s), if s > 3.0 && s <= 6.0 { 1.0 } else { 0.0 }, "{s}");
        assert_eq!(off_alone.at(s), if s <= 6.0 { 1.0 } else { 0.0 }, "{s}");
        assert_eq!(profile(&Light::spot()).distance_ramps.at(s), 1.0);
    }
    assert!(differs > 0.9);
}

/// Planck's law under the CIE 1931 observer by the analytic fit of Wyman, Sloan and Shirley (2013), in linear Rec. 709
/// with a luminance of 1. The fit is within 1 % of the observer, the knots are 500 K apart, and both are shares of
/// channels that reach 2 and more: 0.06 bounds both from 2000 K up. Below that, blue lies outside of Rec. 709.
#[test]
fn color_temperature_is_that_of_a_black_body() {
    fn lobe(x: f64, mean: f64, below: f64, above: f64) -> f64 {
        let t = (x - mean) * if x < mean { below } else { above };
        (-0.5 * t * t).exp()
    }
    let planck = |kelvin: f64| {
        let mut xyz = DVec3::ZERO;
        for nm in 360..=830 {
            let nm = f64::from(nm);
            let power = (nm * 1e-9).powi(-5) / ((1.438_776_9e-2 / (nm * 1e-9 * kelvin)).exp() - 1.0);
            let x = 0.362 * lobe(nm, 442.0, 0.0624, 0.0374) + 1.056 * lobe(nm, 599.8, 0.0264, 0.0323)
                - 0.065 * lobe(nm, 501.1, 0.0490, 0.0382);
            let y = 0.821 * lobe(nm, 568.8, 0.0213, 0.0247) + 0.286 * lobe(nm, 530.9, 0.0613, 0.0322);
            let z = 1.217 * lobe(nm, 437.0, 0.0845, 0.0278) + 0.681 * lobe(nm, 459.0, 0.0385, 0.0725);
            xyz += DVec3::new(x, y, z) * power;
        }
        let rgb = DVec3::new(
            xyz.dot(DVec3::new(3.240_454_2, -1.537_138_5, -0.498_531_4)),
            xyz.dot(DVec3::new(-0.969_266_0, 1.876_010_8, 0.041_556_0)),
            xyz.dot(DVec3::new(0.055_643_4, -0.204_025_9, 1.057_225_2)),
        );
        rgb / xyz.y
    };
    let mut worst = 0.0_f64;
    for kelvin in shares().map(|share| 2000.0 + 8000.0 * share) {
        worst = worst.max((blackbody(kelvin) - planck(kelvin)).abs().max_element());
    }
    assert!(worst < 0.06, "{worst}");
    // Deliberate fault that the check must detect: 500 K off.
    assert!((blackbody(3500.0) - planck(3000.0)).abs().max_element() > 0.06);
    for kelvin in [0.0, 999.0, 1000.0, 1300.0, 6500.0, 1e4, 1e9] {
        let rgb = blackbody(kelvin);
        assert!(rgb.is_finite() && rgb.min_element() >= 0.0);
        let luminance = rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722));
        // Blue is negative near 1300 K and is clamped after the luminance is taken.
        assert!((luminance - 1.0).abs() < 2e-3, "{kelvin}: {luminance}");
    }
    assert_eq!(blackbody(500.0), blackbody(1000.0));
}

/// One number dims a BendyLight: it multiplies all of the light.
#[test]
fn the_tint_multiplies_the_whole_light() {
    let spot = Light::spot().with(COLOR, DVec3::new(1.0, 0.5, 0.25)).with(INTENSITY, 60.0).with(EXPOSURE, -1.0);
    let warm = spot.clone().with(ENABLE_COLOR_TEMPERATURE, true).with(COLOR_TEMPERATURE, 3200.0);
    let bent = bend(&spot, 3).expect("valid");
    let expected = DVec3::new(30.0, 15.0, 7.5);
    assert_eq!((profile(&spot).tint, profile(&bent).tint), (expected, expected));
    assert!((profile(&warm).tint - expected * blackbody(3200.0)).length() < 1e-12);
    assert!(bent.points().iter().all(|point| (point.color, point.intensity) == (DVec3::ONE, 1.0)));
    let off = CheckedLight::new(bent.with(ENABLED, false)).expect("valid");
    assert!(off.light_profile().is_dark() && off.light_profile().tint == DVec3::ZERO);
    assert!(!profile(&spot).is_dark());
}

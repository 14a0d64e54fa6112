//! Tests that a fit contains every caster point in the light.

use glam::DQuat;
use light::parameters::{CONE_ANGLE, END_MODE, FRAME, RANGE, ROTATION, SCALE, TRANSLATION, UP};
use light::{EndMode, Light, Tube};

use super::*;
use crate::casters::of_opaque;

/// Pseudorandom numbers from 0 to 1, the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }
}

/// Tubes that bend, taper, twist, are extended, or open wide.
fn lights() -> Vec<Light> {
    let mut numbers = Numbers(7);
    let mut lights = Vec::new();
    for k in 0..120 {
        let segments = 1 + k % 5;
        let mut light = if k % 3 == 0 {
            let spot = Light::spot().with(CONE_ANGLE, 30.0 + 59.9 * numbers.next());
            let range = (k % 2 == 0).then_some(4.0);
            light::bend(&spot.with(RANGE, range), segments).expect("a cone can be bent")
        } else {
            let points = (0..segments + 2).map(|i| DVec3::new(0.0, 0.0, i as f64 * -1.2)).collect();
            Light::bendy(points, (0..segments + 2).map(|_| 0.1 + 0.6 * numbers.next()).collect())
        };
        let reach = if k % 6 == 0 { 0.02 } else { 0.4 * numbers.next() };
        for point in &mut light.points_mut().expect("it is bent")[1..] {
            point.position += numbers.vector() * reach;
        }
        if k % 4 == 1 {
            light = light.with(FRAME, FrameMode::Up).with(UP, DVec3::Y);
        }
        if k % 5 == 2 {
            light.set(END_MODE.to(EndMode::Extend));
        }
        light.set(TRANSLATION.to(numbers.vector() * 3.0));
        light.set(ROTATION.to(DQuat::from_scaled_axis(numbers.vector() * 3.0)));
        light.set(SCALE.to(0.5 + numbers.next()));
        if Tube::new(&light).is_ok() {
            lights.push(light);
        }
    }
    lights
}

/// Returns the tube-space point at `(t, v, w)`: `P + R (v v_hat + w w_hat)`.
fn point_at(tube: &Tube<f64>, t: f64, v: f64, w: f64) -> DVec3 {
    let segment = (t as usize).min(tube.n - 1);
    let (curve, u) = (&tube.segments[segment].curve, t - segment as f64);
    let (v_hat, w_hat) = tube.cross_section(curve, curve.u_hat(u));
    curve.position(u) + (v_hat * v + w_hat * w) * curve.radius(u)
}

const ORIGIN: DVec3 = DVec3::new(0.7, -0.4, 0.2);

/// Returns clusters of small triangles around the tube and a few large triangles, in scene space.
fn soup(tube: &Tube<f64>, seed: u64) -> Vec<[f32; 3]> {
    let mut numbers = Numbers(seed);
    let mut positions = Vec::new();
    for lump in 0..=seed % 3 {
        let segment = &tube.segments[(numbers.next() * tube.n as f64) as usize].curve;
        let u = numbers.next();
        let beside = segment.position(u) + numbers.vector() * (1.2 * segment.radius(u));
        let middle = tube.placement.world_from_tube(beside) - ORIGIN;
        let (count, size) = if lump == 2 { (2, 3.0) } else { (150, 0.4 * numbers.next()) };
        for _ in 0..3 * count {
            positions.push((middle + numbers.vector() * size).as_vec3().to_array());
        }
    }
    positions
}

/// Returns the fit of a light's map to casters near it, and tube coordinates of points on them.
fn fitted(light: &Light, seed: u64) -> (BendyFit, Vec<[f64; 4]>) {
    let tube = Tube::new(light).expect("checked before");
    let positions = soup(&tube, seed);
    let indices: Vec<u32> = (0..positions.len() as u32).collect();
    let clusters = of_opaque(&positions, &indices);
    let t_max = super::super::t_max(&tube, ORIGIN, DVec3::splat(8.0));
    let fit = BendyFit::new(&tube, Faces::of(light), t_max, ORIGIN, &clusters, Culling::ALL);
    (fit, coords_on(&tube, &positions, &mut Numbers(seed)))
}

/// Returns the tube coordinates of points spread over the triangles.
fn coords_on(tube: &Tube<f64>, positions: &[[f32; 3]], numbers: &mut Numbers) -> Vec<[f64; 4]> {
    let mut found = Vec::new();
    for corners in positions.as_chunks::<3>().0 {
        let [a, b, c] = corners.map(|p| ORIGIN + glam::Vec3::from(p).as_dvec3());
        for k in 0..12 {
            let (x, y) = (numbers.next(), numbers.next());
            let (x, y) = if x + y > 1.0 { (1.0 - x, 1.0 - y) } else { (x, y) };
            // Includes corners and edges, which reach farthest.
            let (x, y) = match k {
                0 => (0.0, 0.0),
                1 => (1.0, 0.0),
                2 => (0.0, 1.0),
                3 => (x, 0.0),
                _ => (x, y),
            };
            let q = tube.placement.tube_from_world(a + (b - a) * x + (c - a) * y);
            tube.for_each_root(q, |root| {
                found.push([root.v_len, root.w_len, root.radius, root.segment as f64 + root.u]);
            });
        }
    }
    found
}

/// Returns the face that contains a point, and x / depth and y / depth there.
fn on_face(fit: &BendyFit, [v, w, radius, _]: [f64; 4]) -> (usize, [f64; 2]) {
    let depth = radius / fit.faces.slope();
    let face = match () {
        () if !fit.faces.is_cube() || depth >= v.abs().max(w.abs()) => 0,
        () if v.abs() >= w.abs() => 1 + usize::from(v < 0.0),
        () => 3 + usize::from(w < 0.0),
    };
    let on_face = fit.faces.face_from_tube(face) * DVec3::new(v, w, radius);
    (face, [on_face.x / on_face.z, on_face.y / on_face.z])
}

/// True if a fit contains a point after each side of its bounds shrinks by the share `cut` of their size.
fn contains(fit: &BendyFit, coords: [f64; 4], cut: f64) -> bool {
    let (face, at) = on_face(fit, coords);
    let inside = |x: f64, [low, high]: Range| {
        let less = cut * (high - low) - 1e-12;
        (low + less..=high - less).contains(&x)
    };
    let bounds = fit.bounds[face];
    bounds.is_some_and(|[x, y]| inside(at[0], x) && inside(at[1], y))
        && fit.t.is_some_and(|range| inside(coords[3], range))
}

/// True if the drawn part of a face extends `texels` beyond a point, or to the rim of the tube.
fn reaches(fit: &BendyFit, drawn_side: f64, coords: [f64; 4], texels: f64) -> bool {
    let (face, at) = on_face(fit, coords);
    let DrawnFace { center, half } = fit.drawn(face, drawn_side);
    (0..2).all(|axis| {
        let margin = 2.0 * half[axis] * texels / SIDE - 1e-9;
        [-1.0, 1.0].into_iter().zip(fit.faces.limits(face)[axis]).all(|(sign, limit)| {
            let edge = center[axis] + sign * half[axis];
            let rim = !fit.faces.is_cube() || limit.abs() < 1.0;
            sign * (edge - at[axis]) >= margin || (rim && sign * (limit - edge) <= 1e-9)
        })
    })
}

const SIDE: f64 = 512.0;

/// The filter reads two texels beyond a point. Those are drawn, at the edges of a fit and across edges of faces.
#[test]
fn the_filter_reads_only_drawn_texels() {
    let (mut caught, mut cubes) = (0, 0);
    for (seed, light) in (0..).zip(lights()) {
        let (fit, coords) = fitted(&light, seed);
        // All directions that a receiver may have on the faces of a cube, and the casters.
        let all_around = (0..4000).map(|k| {
            let (radius, angle) = ((f64::from(k) / 4000.0).sqrt(), f64::from(k) * 2.4);
            [radius * libm::cos(angle), radius * libm::sin(angle), 1.0, 0.0]
        });
        let whole = BendyFit { bounds: [None; MAX_FACES], ..fit };
        let judged = || coords.iter().map(|&p| (fit, p)).chain(all_around.clone().map(|p| (whole, p)));
        for (fit, at) in judged() {
            assert!(reaches(&fit, SIDE, at, MARGIN_TEXELS), "{at:?} of light {seed} in {fit:?}");
        }
        cubes += usize::from(fit.faces.is_cube());
        // Deliberate fault that the check must detect: no margin, as with infinitely many texels.
        caught += usize::from(judged().any(|(fit, at)| !reaches(&fit, 1e9, at, MARGIN_TEXELS)));
    }
    assert!(cubes > 5 && caught >= cubes, "a margin of 0 is seen in only {caught} of {cubes} lights");
}

#[test]
fn a_fit_contains_all_casters() {
    let (mut checked, mut empty, mut cubes, mut caught) = (0, 0, 0, 0);
    for (seed, light) in (0..).zip(lights()) {
        let (fit, coords) = fitted(&light, seed);
        for &at in &coords {
            assert!(contains(&fit, at, 0.0), "{at:?} of light {seed} is not in {fit:?}");
        }
        checked += coords.len();
        empty += usize::from(fit.t.is_none());
        cubes += usize::from(fit.faces.is_cube());
        // Deliberate fault that the check must detect: bounds that are slightly too small.
        caught += usize::from(coords.iter().any(|&at| !contains(&fit, at, 0.05)));
    }
    assert!(checked > 10_000 && empty > 0 && cubes > 5, "{checked} points, {empty} empty, {cubes} cubes");
    assert!(caught > 15, "bounds that are too small are seen in only {caught} lights");
}

/// No light path comes back in through a side that the fit excludes. Deliberate fault that the check must detect: a
/// rule that excludes every side misses the paths that do come back in.
#[test]
fn no_path_enters_through_an_excluded_side() {
    let mut numbers = Numbers(3);
    let (mut trusted, mut back) = (0, 0);
    for light in lights() {
        let tube = Tube::new(&light).expect("checked before");
        let pieces = pieces(&tube, tube.n as f64 + 1.0, ORIGIN);
        for axis in [DVec3::X, DVec3::Y, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z] {
            let through = tube.placement.world_from_tube(point_at(&tube, numbers.next() * tube.n as f64, 0.0, 0.0));
            let side = OpenSide { normal: axis, offset: axis.dot(through - ORIGIN) };
            let returns = (0..24).any(|k| {
                let (v, w) = (0.97 * libm::cos(k.into()), 0.97 * libm::sin(k.into()));
                let mut outside = false;
                (0..=60).any(|step| {
                    let at = point_at(&tube, tube.n as f64 * f64::from(step) / 60.0, v, w);
                    let height = side.height(tube.placement.world_from_tube(at) - ORIGIN);
                    outside |= height > 1e-4;
                    outside && height < -1e-4
                })
            });
            let comes_in = may_enter(&pieces, &tube, &side, ORIGIN);
            assert!(comes_in || !returns, "a path comes back in through {side:?} of {light:?}");
            trusted += usize::from(!comes_in);
            back += usize::from(returns);
        }
    }
    assert!(trusted > 50 && back > 50, "{trusted} sides are trusted, through {back} light comes back");
}

//! Sixteen lanes find the same bits in a light as `f32` does.

use light::parameters::{DIRECTION, END_MODE, FRAME, PROFILE};
use light::{DirectionMode, EndMode, FrameMode, Light, ProfileCurve, Tube, TubeRoot};

use super::*;
use crate::bent::splat_tube;
use crate::simd::{self, SimdTask};

/// Linear congruential generator of numbers from 0 to 1, the same everywhere.
struct RandomNumbers(u32);

impl RandomNumbers {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / 16_777_216.0
    }
}

/// Makes lights of several shapes with all frames, directions and ends.
fn lights() -> Vec<Light> {
    let bent = |points: &[[f64; 3]], radii: &[f64]| {
        Light::bendy(points.iter().map(|point| DVec3::from_array(*point)).collect(), radii.to_vec())
    };
    let bow = [[0.0, 0.0, 0.0], [0.3, 0.4, -0.8], [0.9, 0.7, -1.7], [1.6, 0.2, -2.4], [1.9, -0.8, -2.9]];
    let bow = bent(&bow, &[0.1, 0.25, 0.4, 0.5, 0.6]);
    let straight = bent(&[[0.0; 3], [0.0, 0.0, -1.0], [0.0, 0.0, -2.0]], &[0.0, 0.4, 0.8]);
    let mut all = Vec::new();
    for light in [bow, straight] {
        for frame in [FrameMode::RotationMinimizing, FrameMode::Up] {
            for direction in [DirectionMode::Tube, DirectionMode::Path] {
                for end in [EndMode::Cut, EndMode::Extend] {
                    let light = light.clone().with(FRAME, frame).with(DIRECTION, direction);
                    all.push(light.with(END_MODE, end));
                }
            }
        }
    }
    all
}

/// Finds the roots of sixteen points on one segment, as eight numbers each: u, V, W, R, the direction and the path
/// length.
struct OnSegment<'a> {
    tube: &'a Tube<F32s>,
    segment: usize,
    q: Vec3s,
}

impl SimdTask for OnSegment<'_> {
    type Output = ([Masks; 2], [[F32s; 8]; 2]);

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self { tube, segment, q } = self;
        let mut f0 = tube.first_joint(q);
        for i in 0..segment {
            f0 = tube.end_joint(i, q);
        }
        let roots = tube.candidates(segment, q, f0, tube.end_joint(segment, q));
        let left = at(tube, segment, q, roots.left);
        let right = at(tube, segment, q, roots.right);
        ([roots.has_left & left.0, roots.has_right & right.0], [left.1, right.1])
    }
}

#[inline(always)]
fn at(tube: &Tube<F32s>, segment: usize, q: Vec3s, u: F32s) -> (Masks, [F32s; 8]) {
    let (inside, is_inside) = tube.inside_at(segment, q, u);
    (is_inside, numbers(tube, &tube.root_at(&inside)))
}

#[inline(always)]
fn numbers<F: Lanes>(tube: &Tube<F>, root: &TubeRoot<F>) -> [F; 8] {
    let [x, y, z] = F::coordinates(tube.direction_at(root));
    [root.u, root.v_len, root.w_len, root.radius, x, y, z, tube.path_length(root)]
}

#[test]
fn sixteen_lanes_find_what_one_finds() {
    let mut spread = RandomNumbers(7);
    let mut compared = 0;
    for light in lights() {
        let tube = Tube::new(&light).expect("the light is sound");
        let (one, many) = (Tube::<f32>::from(&tube), splat_tube(&tube));
        for _ in 0..200 {
            let mut q = Vec3s::splat([0.0; 3]);
            for i in 0..LANES {
                // Points around the curve, and a little outside the tube.
                let segment = &one.segments[(spread.next() * one.n as f32) as usize].curve;
                let middle = segment.position(spread.next());
                let beside = [0; 3].map(|_| (spread.next() - 0.5) * 1.2);
                (q.x.0[i], q.y.0[i], q.z.0[i]) = (middle.x + beside[0], middle.y + beside[1], middle.z + beside[2]);
            }
            let found: Vec<_> =
                (0..many.segments.len()).map(|segment| simd::run(OnSegment { tube: &many, segment, q })).collect();
            for i in 0..LANES {
                one.for_each_root(q.lane(i), |root| {
                    let (has, values) = &found[root.segment];
                    let expected = numbers(&one, &root).map(f32::to_bits);
                    let same = (0..2).any(|k| has[k].lane(i) && values[k].map(|x| x.0[i].to_bits()) == expected);
                    assert!(same, "{root:?} is not what {found:?} have in lane {i}");
                    compared += 1;
                    // Deliberate fault that the check must detect: another lane's answer.
                    let other = (i + 1) % LANES;
                    assert!((0..2).all(|k| values[k].map(|x| x.0[other].to_bits()) != expected));
                });
            }
        }
    }
    assert!(compared > 3_000, "{compared} roots were compared");
}

/// Attenuation of light, one share per lane.
struct Shares<'a>(&'a light::LightProfile, [F32s; 3]);

impl SimdTask for Shares<'_> {
    type Output = F32s;

    #[inline(always)]
    fn run(self) -> F32s {
        let Self(filter, [v, w, s]) = self;
        filter.attenuation_at(v, w, s)
    }
}

/// Lanes compute powers and angles differently: within the bounds of `elementary`, times the factors that follow.
#[test]
fn light_falls_off_as_it_does_in_double_precision() {
    let mut spread = RandomNumbers(3);
    let light = lights().remove(0);
    for curve in [ProfileCurve::Smooth, ProfileCurve::Linear, ProfileCurve::Power, ProfileCurve::Cosine] {
        let tube = Tube::new(&light.clone().with(PROFILE, curve)).expect("the light is sound");
        for _ in 0..500 {
            let coords = [0; 3].map(|_| spread.next());
            let many = simd::run(Shares(&tube.light_profile, coords.map(F32s::splat)));
            let [v, w, s] = coords.map(f64::from);
            let one = tube.light_profile.attenuation_at(v, w, s);
            // f32 rounds (1 - share) / span, where span is about a fifth of the whole, and curves are at most three
            // times as steep.
            assert!((f64::from(many.0[5]) - one).abs() < 1e-5, "{curve:?} at {coords:?}: {} for {one}", many.0[5]);
        }
    }
}

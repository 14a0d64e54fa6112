//! Solver of the light model for sixteen points at once, for `bendylights bench solver`.

use glam::Vec3;
use light::{Curve, Lanes, Roots, increasing_roots};

use crate::bent::splat_curve;
use crate::lanes::{F32s, LANES, Vec3s};
use crate::simd::{self, SimdTask};

/// Sixteen points to locate, each on a curve of its own.
#[derive(Clone, Debug)]
pub struct SolverBatch {
    curve: Curve<F32s>,
    q: Vec3s,
}

impl SolverBatch {
    /// Makes a batch of any curves, whatever their boxes, frames and radii.
    pub fn new(cases: &[(Curve<f32>, Vec3); LANES]) -> Self {
        let mut sixteen = Self { curve: splat_curve(&cases[0].0), q: Vec3s::splat([0.0; 3]) };
        for (lane, (curve, q)) in cases.iter().enumerate() {
            let Curve { b0, b2, d0, d1, a, .. } = &mut sixteen.curve;
            let vectors = [(b0, curve.b0), (b2, curve.b2), (d0, curve.d0), (d1, curve.d1), (a, curve.a)];
            for (lanes, vector) in vectors.into_iter().chain([(&mut sixteen.q, *q)]) {
                (lanes.x.0[lane], lanes.y.0[lane], lanes.z.0[lane]) = (vector.x, vector.y, vector.z);
            }
        }
        sixteen
    }
}

impl SimdTask for &SolverBatch {
    type Output = Roots<F32s>;

    #[inline(always)]
    fn run(self) -> Roots<F32s> {
        let SolverBatch { curve, q } = self;
        let f0 = -F32s::dot(*q - curve.b0, curve.d0);
        let f1 = -F32s::dot(*q - curve.b2, curve.d1);
        increasing_roots(curve, *q, f0, f1)
    }
}

/// Computes the increasing roots of each case, like [`light::increasing_roots`].
pub fn solve_batch(cases: &SolverBatch) -> [Roots<f32>; LANES] {
    let roots = simd::run(cases);
    std::array::from_fn(|lane| Roots {
        left: roots.left.0[lane],
        right: roots.right.0[lane],
        has_left: roots.has_left.lane(lane),
        has_right: roots.has_right.lane(lane),
    })
}

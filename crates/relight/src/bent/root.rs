//! Selection of the root that counts, for sixteen points.

use light::{Lanes, Mask, Tube};

use crate::lanes::{F32s, Masks, Vec3s};

/// Root with the smallest |r| / R of each point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    /// Lanes whose points lie in the tube.
    pub found: Masks,
    /// Index of the segment.
    pub segment: F32s,
    /// Curve parameter in the segment.
    pub u: F32s,
    r2: F32s,
    radius: F32s,
}

/// Finds the roots of the points `q` in tube space, for the `active` lanes. At a joint both segments give the same root
/// up to rounding, and either will do.
#[inline(always)]
pub(crate) fn nearest(tube: &Tube<F32s>, q: Vec3s, active: Masks) -> Nearest {
    let zero = F32s::splat(0.0);
    let mut best = Nearest { found: Masks::of(false), segment: zero, u: zero, r2: zero, radius: zero };
    let mut f0 = tube.first_joint(q);
    for i in 0..tube.segments.len() {
        let f1 = tube.end_joint(i, q);
        let roots = tube.candidates(i, q, f0, f1);
        if (active & roots.has_left).any() {
            consider(&mut best, tube, i, q, roots.left, active & roots.has_left);
        }
        if (active & roots.has_right).any() {
            consider(&mut best, tube, i, q, roots.right, active & roots.has_right);
        }
        f0 = f1;
    }
    best
}

#[inline(always)]
fn consider(best: &mut Nearest, tube: &Tube<F32s>, i: usize, q: Vec3s, u: F32s, has: Masks) {
    let (inside, is_inside) = tube.inside_at(i, q, u);
    let nearer = (inside.r2 * best.radius * best.radius).lt(best.r2 * inside.radius * inside.radius);
    let better = has & is_inside & (nearer | !best.found);
    best.found = best.found | better;
    best.segment = F32s::select(better, F32s::splat(i as f32), best.segment);
    best.u = F32s::select(better, u, best.u);
    best.r2 = F32s::select(better, inside.r2, best.r2);
    best.radius = F32s::select(better, inside.radius, best.radius);
}

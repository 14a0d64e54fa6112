//! The product's solver, eight at once on the processor: the twin of bendy's `solve.rs` without a branch.
//!
//! Every lane does what the scalar code does, in its order; both sides of each condition are computed and one is
//! taken. A quotient whose guard fails may be infinite or NaN in a lane that is then not taken. All is inlined: a vector
//! that is handed over in memory costs more than what is done with it.

use glam::Vec3;
use light::{Curve, Lanes};
use wide::f32x8;

use super::family::Case;
use super::found::Found;

/// Lanes.
pub const LANES: usize = 8;

/// Eight vectors.
#[derive(Clone, Copy)]
struct Vec3x8 {
    x: f32x8,
    y: f32x8,
    z: f32x8,
}

impl Vec3x8 {
    fn of(vectors: [Vec3; LANES]) -> Self {
        let [x, y, z] = [0, 1, 2].map(|axis| f32x8::from(vectors.map(|v| v[axis])));
        Self { x, y, z }
    }

    #[inline]
    fn dot(self, other: Self) -> f32x8 {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline]
    fn minus(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }

    /// `self + other * factor`.
    #[inline]
    fn plus(self, other: Self, factor: f32x8) -> Self {
        Self { x: self.x + other.x * factor, y: self.y + other.y * factor, z: self.z + other.z * factor }
    }

    /// `one` in the lanes of the mask, `other` in the rest.
    #[inline]
    fn select(mask: f32x8, one: Self, other: Self) -> Self {
        Self {
            x: mask.select(one.x, other.x),
            y: mask.select(one.y, other.y),
            z: mask.select(one.z, other.z),
        }
    }

    #[inline]
    fn times(self, factor: f32x8) -> Self {
        Self { x: self.x * factor, y: self.y * factor, z: self.z * factor }
    }
}

/// Eight questions, one a lane.
pub struct Cases8 {
    b0: Vec3x8,
    b2: Vec3x8,
    d0: Vec3x8,
    d1: Vec3x8,
    a: Vec3x8,
    q: Vec3x8,
}

impl Cases8 {
    /// Cases of any eight segments.
    pub fn new(cases: &[Case<f32>; LANES]) -> Self {
        let of = |field: fn(&Curve<f32>) -> Vec3| Vec3x8::of(std::array::from_fn(|k| field(&cases[k].curve)));
        Self {
            b0: of(|s| s.b0),
            b2: of(|s| s.b2),
            d0: of(|s| s.d0),
            d1: of(|s| s.d1),
            a: of(|s| s.a),
            q: Vec3x8::of(std::array::from_fn(|k| cases[k].q)),
        }
    }
}

/// The root on each lane's left increasing piece and on its right one, with a mask of those that there are.
pub struct Roots8 {
    roots: [f32x8; 2],
    exist: [f32x8; 2],
}

impl Roots8 {
    /// Lane by lane.
    pub fn found(&self) -> [Found<f32>; LANES] {
        let roots = self.roots.map(f32x8::to_array);
        let exist = self.exist.map(f32x8::to_bitmask);
        std::array::from_fn(|lane| {
            let mut found = Found::none();
            found.extend((0..2).filter(|&side| exist[side] >> lane & 1 == 1).map(|side| roots[side][lane]));
            found
        })
    }
}

const ZERO: f32x8 = f32x8::ZERO;
const ONE: f32x8 = f32x8::ONE;

/// `select` where neither side is NaN in a lane that counts; as the scalar `within`.
#[inline]
fn within(x: f32x8, low: f32x8, high: f32x8) -> f32x8 {
    x.fast_max(low).fast_min(high)
}

#[inline]
fn sdiv(n: f32x8, d: f32x8) -> f32x8 {
    let limit = f32x8::splat(64.0);
    let same_sign = !(n.simd_lt(ZERO) ^ d.simd_lt(ZERO));
    let limited = same_sign.select(limit, -limit);
    let quotient = d.simd_ne(ZERO).select(n / d, ZERO);
    n.abs().simd_le(limit * d.abs()).select(quotient, limited)
}

struct Cubic8 {
    c1: f32x8,
    c2: f32x8,
    c3: f32x8,
}

impl Cubic8 {
    #[inline]
    fn slope(&self, u: f32x8) -> f32x8 {
        (3.0 * self.c3 * u + 2.0 * self.c2) * u + self.c1
    }
    #[inline]
    fn half_curvature(&self, u: f32x8) -> f32x8 {
        3.0 * self.c3 * u + self.c2
    }
}

#[inline]
fn climb(f: f32x8, g: f32x8, h: f32x8, a: f32x8, t_max: f32x8) -> f32x8 {
    let mut t = t_max;
    t = f.simd_lt(g * t).select(f / g, t);
    t = f.simd_lt(h * t * t).select((f / h).sqrt(), t);
    let cubic = f32x8::from((f / a).to_array().map(Lanes::cbrt_above));
    t = f.simd_lt(a * t * t * t).select(cubic.fast_min(t), t);
    for _ in 0..<f32 as Lanes>::NEWTON_STEPS {
        let value = ((a * t + h) * t + g) * t - f;
        let slope = (3.0 * a * t + 2.0 * h) * t + g;
        t = slope.simd_gt(ZERO).select(within(t - value / slope, ZERO, t_max), t);
    }
    t
}

/// `(r, d)` at `u`: the offset from the curve and half the curve's derivative.
#[inline]
fn at(cases: &Cases8, from_start: Vec3x8, u: f32x8) -> (Vec3x8, Vec3x8) {
    let travelled = cases.d0.times(f32x8::splat(2.0)).plus(cases.a, u).times(u);
    let d = Vec3x8::select(u.simd_eq(ONE), cases.d1, cases.d0.plus(cases.a, u));
    (from_start.minus(travelled), d)
}

#[inline]
fn polish(cases: &Cases8, from_start: Vec3x8, u: f32x8, low: f32x8, high: f32x8) -> f32x8 {
    let (r, d) = at(cases, from_start, u);
    let (n, slope) = (r.dot(d), 2.0 * d.dot(d) - r.dot(cases.a));
    let half_curvature = 3.0 * cases.a.dot(d);
    let short = n.abs().simd_le(slope * 0.015_625)
        & (n * half_curvature).abs().simd_le(0.25 * slope * slope)
        & slope.simd_gt(ZERO);
    within(u + short.select(n / slope, ZERO), low, high)
}

/// The increasing roots of eight cases; see [`light::increasing_roots`].
pub fn increasing_roots_8(cases: &Cases8) -> Roots8 {
    let Cases8 { b0, b2, d0, d1, a, q } = *cases;
    let (from_start, from_end) = (q.minus(b0), q.minus(b2));
    let (d0_d0, across) = (d0.dot(d0), from_start.dot(a));
    let (f0, f1) = (-from_start.dot(d0), -from_end.dot(d1));
    let cubic = Cubic8 { c1: 2.0 * d0_d0 - across, c2: 3.0 * d0.dot(a), c3: a.dot(a) };
    let e0 = d0_d0.simd_gt(ZERO).select(f0, -across);
    let e1 = d1.dot(d1).simd_gt(ZERO).select(f1, from_end.dot(a));

    let discriminant = cubic.c2 * cubic.c2 - 3.0 * cubic.c3 * cubic.c1;
    let root = discriminant.fast_max(ZERO).sqrt();
    let qd = -(cubic.c2 + cubic.c2.simd_lt(ZERO).select(-root, root));
    let (x, y) = (sdiv(qd, 3.0 * cubic.c3), sdiv(cubic.c1, qd));
    let inflection = within(sdiv(-cubic.c2, 3.0 * cubic.c3), ZERO, ONE);
    let turns = discriminant.simd_gt(ZERO);
    let cl = turns.select(within(x.fast_min(y), ZERO, ONE), inflection);
    let ch = turns.select(within(x.fast_max(y), ZERO, ONE), inflection);

    let at_end = |u: f32x8, start: f32x8, end: f32x8, inside: f32x8| {
        u.simd_ne(ZERO).select(u.simd_ne(ONE).select(inside, end), start)
    };
    let f = |u: f32x8| {
        let (r, d) = at(cases, from_start, u);
        -r.dot(d)
    };
    let fl = at_end(cl, f0, f1, f(cl));
    let fh = at_end(ch, f0, f1, f(ch).fast_min(fl));
    let sl = at_end(cl, e0, e1, fl);
    let sh = at_end(ch, e0, e1, fh);

    let rises =
        [cl.simd_gt(ZERO) | cubic.slope(cl).simd_ge(ZERO), ch.simd_lt(ONE) | cubic.slope(ch).simd_ge(ZERO)];
    let g = cubic.slope(cl).fast_max(ZERO);
    let h = (-cubic.half_curvature(cl)).fast_max(ZERO);
    let left = polish(cases, from_start, cl - climb(fl.abs(), g, h, cubic.c3, cl), ZERO, cl);
    let g = cubic.slope(ch).fast_max(ZERO);
    let h = cubic.half_curvature(ch).fast_max(ZERO);
    let right = polish(cases, from_start, ch + climb(fh.abs(), g, h, cubic.c3, ONE - ch), ch, ONE);
    let exist =
        [e0.simd_le(ZERO) & ZERO.simd_le(sl) & rises[0], sh.simd_le(ZERO) & ZERO.simd_le(e1) & rises[1]];
    Roots8 { roots: [left, right], exist }
}

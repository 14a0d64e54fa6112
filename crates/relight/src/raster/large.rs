//! Drawing of triangles of any size and of clipped ones: row by row, from the first covered texel to the last, which
//! f64 computes exactly.
#![expect(clippy::cast_possible_wrap, reason = "positions on a map are far below 2^31")]

use super::Band;
use super::ids::TriangleIds;
use super::rule::DepthTest;
use super::wide::{F32s, Ints, LANES};

/// True if corners are clockwise on the face, as those of a triangle are that is seen from behind.
pub(super) fn is_clockwise(corners: &[Corner; 3]) -> bool {
    let [p, q, r] = corners.map(|corner| corner.at.map(i64::from));
    (q[0] - p[0]) * (r[1] - p[1]) > (r[0] - p[0]) * (q[1] - p[1])
}

/// Corner of a triangle on a face.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    /// Offset to the right and down from the center of the first texel, in 1/256 of a texel; at most 2^22 in each
    /// direction.
    pub at: [i32; 2],
    /// Value of N of [`DepthTest`] at the corner. The next field is D.
    pub n: f32,
    pub d: f32,
}

/// Triangle, set up. Its numbers are exact integers below 2^48 where `SmallTriangle` has integers.
#[derive(Clone, Copy, Debug)]
pub(super) struct LargeTriangle {
    /// First and last column and row of the texels whose centers may be covered.
    pub columns: [i32; 2],
    pub rows: [i32; 2],
    /// Least column of the whole triangle, from which N and D are interpolated in each part of a picture.
    anchor: i32,
    /// Number of the triangle; see [`TriangleIds`].
    pub id: u32,
    /// Edge functions like those of `SmallTriangle`: `c + a i + b j` at the texel in column `i` and row `j` of the
    /// face.
    a: [f64; 3],
    b: [f64; 3],
    c: [f64; 3],
    n: Plane,
    d: Plane,
}

/// Linear function on the face, like N and D of `SmallTriangle`: the first number, plus the others times the edge
/// functions of the second and the third corner.
pub(super) type Plane = [f64; 3];

/// Covered texels of a triangle in one row, with N and D of [`DepthTest`] along them from the anchor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Run {
    /// First covered column. The next field is the number of columns.
    pub first: usize,
    pub count: usize,
    /// Columns from the anchor to the first covered one.
    pub from_anchor: i32,
    /// Value of N at the anchor. The next field is D.
    pub n: f32,
    pub d: f32,
    /// Change of N from one column to the next. The next field is that of D.
    pub n_step: f32,
    pub d_step: f32,
}

impl LargeTriangle {
    /// Sets up a triangle. `None` if it cannot cover one of `size` texels.
    pub fn new(corners: [Corner; 3], size: [usize; 2]) -> Option<Self> {
        Self::with_planes(corners, [], size).map(|(large, [])| large)
    }

    /// Sets up a triangle, and a plane for each list of `others`, which has a value per corner.
    pub fn with_planes<const N: usize>(
        corners: [Corner; 3],
        others: [[f64; 3]; N],
        size: [usize; 2],
    ) -> Option<(Self, [Plane; N])> {
        let [p, q, r] = corners.map(|corner| corner.at.map(i64::from));
        let doubled_area = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
        let range = |axis: usize| {
            let [least, most] = [p[axis].min(q[axis]).min(r[axis]), p[axis].max(q[axis]).max(r[axis])];
            [((least + 255) >> 8).max(0) as i32, (most >> 8).min(size[axis] as i64 - 1) as i32]
        };
        let [columns, rows] = [range(0), range(1)];
        if doubled_area == 0 || columns[0] > columns[1] || rows[0] > rows[1] {
            return None;
        }
        let sign = doubled_area.signum();
        // Edge from the second to the third of the corners, named by the first.
        let edge = |from: [i64; 2], to: [i64; 2]| {
            let (a, b) = (sign * (from[1] - to[1]), sign * (to[0] - from[0]));
            // Centers on top and left edges are covered.
            let uncovered = i64::from(!(a > 0 || a == 0 && b > 0));
            let at_origin = -(a * from[0] + b * from[1]);
            let c = (at_origin - uncovered) >> 8;
            ([a as f64, b as f64, c as f64], (at_origin - 256 * c) as f64)
        };
        let [(e0, _), (e1, rest1), (e2, rest2)] = [edge(q, r), edge(r, p), edge(p, q)];
        let per_area = (doubled_area.abs() as f64).recip();
        let plane = |x: [f64; 3]| {
            let [one, two] = [1, 2].map(|k| (x[k] - x[0]) * per_area);
            [x[0] + rest1 * one + rest2 * two, 256.0 * one, 256.0 * two]
        };
        let of = |k: usize| [e0[k], e1[k], e2[k]];
        let large = Self {
            columns,
            rows,
            anchor: p[0].min(q[0]).min(r[0]).div_euclid(256) as i32,
            id: 0,
            a: of(0),
            b: of(1),
            c: of(2),
            n: plane(corners.map(|corner| f64::from(corner.n))),
            d: plane(corners.map(|corner| f64::from(corner.d))),
        };
        Some((large, others.map(plane)))
    }

    /// Returns the number of texels of the bounding box in a band.
    pub fn texels_in<Ids>(&self, band: &Band<Ids>) -> usize {
        let first = (self.rows[0] as usize).max(band.first);
        let end = (self.rows[1] as usize + 1).min(band.end);
        end.saturating_sub(first) * ((self.columns[1] - self.columns[0]) as usize + LANES)
    }

    /// Evaluates D and three other planes at the center of a texel.
    #[inline(always)]
    pub fn at(&self, others: &[Plane; 3], column: usize, row: usize) -> (f64, [f64; 3]) {
        let (x, y) = (column as f64, row as f64);
        let one = self.a[1] * x + self.b[1] * y + self.c[1];
        let two = self.a[2] * x + self.b[2] * y + self.c[2];
        let [p, q, r] = others;
        (
            evaluate_plane(&self.d, one, two),
            [evaluate_plane(p, one, two), evaluate_plane(q, one, two), evaluate_plane(r, one, two)],
        )
    }

    /// Finds the covered texels of a row. The quotient of integers below 2^53 never rounds to an integer that it is
    /// not, so its floor and ceiling are exact.
    #[inline(always)]
    pub fn run(&self, row: usize) -> Option<Run> {
        let y = row as f64;
        let [mut first, mut last] = [f64::from(self.columns[0]), f64::from(self.columns[1])];
        let starts = [self.b[0] * y + self.c[0], self.b[1] * y + self.c[1], self.b[2] * y + self.c[2]];
        for (k, start) in starts.into_iter().enumerate() {
            let zero = -start / self.a[k];
            if self.a[k] > 0.0 {
                first = first.max(zero.ceil());
            } else if self.a[k] < 0.0 {
                last = last.min(zero.floor());
            } else if start < 0.0 {
                return None;
            }
        }
        if first > last {
            return None;
        }
        let anchor = f64::from(self.anchor);
        let (one, two) = (starts[1] + self.a[1] * anchor, starts[2] + self.a[2] * anchor);
        let (n, d) = (self.n, self.d);
        Some(Run {
            first: first as i32 as usize,
            count: (last - first) as i32 as usize + 1,
            from_anchor: first as i32 - self.anchor,
            n: evaluate_plane(&n, one, two) as f32,
            d: evaluate_plane(&d, one, two) as f32,
            n_step: (n[1] * self.a[1] + n[2] * self.a[2]) as f32,
            d_step: (d[1] * self.a[1] + d[2] * self.a[2]) as f32,
        })
    }
}

impl Run {
    /// Returns the coverage of sixteen texels, from `done` texels after the first, and N and D there.
    #[inline(always)]
    pub fn lanes_from(&self, done: usize, count: Ints) -> (Ints, F32s, F32s) {
        let along = count + Ints::splat(done as i32);
        let covered = Ints::splat(self.count as i32 - 1) - along;
        let along = (along + Ints::splat(self.from_anchor)).floats();
        let n = along.times_plus(F32s::splat(self.n_step), F32s::splat(self.n));
        let d = along.times_plus(F32s::splat(self.d_step), F32s::splat(self.d));
        (covered, n, d)
    }
}

/// Evaluates a plane. `one` and `two` are the edge functions of the second and the third corner.
#[inline(always)]
fn evaluate_plane(plane: &Plane, one: f64, two: f64) -> f64 {
    plane[0] + plane[1] * one + plane[2] * two
}

/// Draws the rows of a triangle that are in a band.
#[inline(always)]
pub(super) fn draw<R: DepthTest, Ids: TriangleIds>(rule: R, large: &LargeTriangle, band: &mut Band<Ids>) {
    let first = (large.rows[0] as usize).max(band.first);
    let end = (large.rows[1] as usize + 1).min(band.end);
    let triangle = rule.triangle(large.id);
    for row in first..end {
        let Some(run) = large.run(row) else { continue };
        let in_row = rule.row(triangle, row);
        let at = (row - band.first) * band.stride + run.first;
        let mut done = 0;
        while done < run.count {
            let Some(texels) = band.texels[at + done..].first_chunk_mut::<LANES>() else { return };
            let (covered, n, d) = run.lanes_from(done, band.lane_indices);
            let before = F32s(*texels);
            let columns = band.lane_indices + Ints::splat((run.first + done) as i32);
            let after = rule.updated_depths(covered, n, d, in_row, columns, before);
            *texels = after.0;
            band.ids.note(at + done, before, after, large.id);
            done += LANES;
        }
    }
}

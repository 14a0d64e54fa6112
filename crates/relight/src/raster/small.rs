//! Drawing of triangles of at most [`MAX_SMALL_TEXELS`] texels in each direction, which most are: in integers of 32
//! bits, 16 texels of a row at a time.
#![expect(clippy::cast_possible_wrap, reason = "positions on a map are far below 2^31")]

use super::Band;
use super::ids::TriangleIds;
use super::rule::DepthTest;
use super::wide::{F32s, Ints, LANES};

/// Largest distance between corners, in texels. In 1/256 of a texel, twice the product of two such distances fits into
/// 32 bits, and 1/256 of that is exact in f32.
pub(super) const MAX_SMALL_TEXELS: i32 = 112;

/// Triangle, or 16 triangles with `Ints` and `F32s` as its numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct SmallTriangle<Int = i32, Float = f32> {
    /// First and last column and row of the texels whose centers may be covered.
    pub columns: [Int; 2],
    pub rows: [Int; 2],
    /// Edge functions, each positive towards the corner that names it: `e + a i + b j` at the texel `i` columns and `j`
    /// rows after the first. A texel is covered if none of its three values is negative.
    pub e: [Int; 3],
    pub a: [Int; 3],
    pub b: [Int; 3],
    /// N is `n[0]`, plus `n[1]` and `n[2]` times the edge functions of the second and the third corner; D likewise.
    pub n: [Float; 3],
    pub d: [Float; 3],
    /// Number of the first lane's triangle; see [`TriangleIds`].
    pub id: u32,
}

impl SmallTriangle<Ints, F32s> {
    /// Returns the triangle in one lane.
    #[inline(always)]
    pub fn lane(&self, k: usize) -> SmallTriangle {
        let Self { columns, rows, e, a, b, n, d, id } = self;
        SmallTriangle {
            columns: [columns[0].0[k], columns[1].0[k]],
            rows: [rows[0].0[k], rows[1].0[k]],
            e: [e[0].0[k], e[1].0[k], e[2].0[k]],
            a: [a[0].0[k], a[1].0[k], a[2].0[k]],
            b: [b[0].0[k], b[1].0[k], b[2].0[k]],
            n: [n[0].0[k], n[1].0[k], n[2].0[k]],
            d: [d[0].0[k], d[1].0[k], d[2].0[k]],
            id: id + k as u32,
        }
    }
}

/// Draws the rows of a triangle that are in a band.
#[inline(always)]
pub(super) fn draw<R: DepthTest, Ids: TriangleIds>(rule: R, small: &SmallTriangle, band: &mut Band<Ids>) {
    let [left, right] = [small.columns[0] as usize, small.columns[1] as usize];
    let top = small.rows[0] as usize;
    let first = top.max(band.first);
    let end = (small.rows[1] as usize + 1).min(band.end);
    let down = (first - top) as i32;
    let n = [F32s::splat(small.n[0]), F32s::splat(small.n[1]), F32s::splat(small.n[2])];
    let d = [F32s::splat(small.d[0]), F32s::splat(small.d[1]), F32s::splat(small.d[2])];
    let first_edge = Edge::new(small, 0, down);
    let second_edge = Edge::new(small, 1, down);
    let third_edge = Edge::new(small, 2, down);
    let last_row = (end as i32 - 1) - first as i32;
    let triangle = rule.triangle(small.id);
    let mut column = left;
    while column <= right {
        let across = (column - left) as i32;
        let columns = band.lane_indices + Ints::splat(column as i32);
        let mut at = (first - band.first) * band.stride + column;
        column += LANES;
        let most = first_edge.max_over_rows(across, last_row)
            | second_edge.max_over_rows(across, last_row)
            | third_edge.max_over_rows(across, last_row);
        if most < 0 {
            continue;
        }
        let mut first_e = first_edge.along(across, band.lane_indices);
        let mut second_e = second_edge.along(across, band.lane_indices);
        let mut third_e = third_edge.along(across, band.lane_indices);
        for row in first..end {
            let Some(texels) = band.texels[at..].first_chunk_mut::<LANES>() else { return };
            let covered = first_e | second_e | third_e;
            let (one, two) = (second_e.floats(), third_e.floats());
            let n = two.times_plus(n[2], one.times_plus(n[1], n[0]));
            let d = two.times_plus(d[2], one.times_plus(d[1], d[0]));
            let before = F32s(*texels);
            let after = rule.updated_depths(covered, n, d, rule.row(triangle, row), columns, before);
            *texels = after.0;
            band.ids.note(at, before, after, small.id);
            first_e = first_e + Ints::splat(first_edge.b);
            second_e = second_e + Ints::splat(second_edge.b);
            third_e = third_e + Ints::splat(third_edge.b);
            at += band.stride;
        }
    }
}

/// Edge function of a triangle, from a row on. Code writes out the three edges, since compilers make slower code of
/// loops over them.
#[derive(Clone, Copy)]
struct Edge {
    e: i32,
    a: i32,
    b: i32,
}

impl Edge {
    #[inline(always)]
    fn new(small: &SmallTriangle, k: usize, down: i32) -> Self {
        let (e, a, b) = (small.e[k], small.a[k], small.b[k]);
        Self { e: e.wrapping_add(b.wrapping_mul(down)), a, b }
    }

    /// Evaluates the function at 16 texels of the first row, from a column on.
    #[inline(always)]
    fn along(self, across: i32, count: Ints) -> Ints {
        Ints::splat(self.e.wrapping_add(self.a.wrapping_mul(across))) + Ints::splat(self.a) * count
    }

    /// Computes the largest value at those columns over the rows up to `last_row`.
    #[inline(always)]
    fn max_over_rows(self, across: i32, last_row: i32) -> i32 {
        let start = self.e.wrapping_add(self.a.wrapping_mul(across));
        let along = start.wrapping_add(self.a.wrapping_mul(LANES as i32 - 1).max(0));
        along.wrapping_add(self.b.wrapping_mul(last_row).max(0))
    }
}

//! Set-up of triangles: finds their position on a face, and lists them by bands of its rows.
#![expect(clippy::cast_possible_wrap, reason = "positions on a map are far below 2^31")]

use pulp::{Simd, WithSimd};

use super::RasterTriangle;
use super::clip::{ClipCorner, Polygon};
use super::large::{Corner, LargeTriangle, is_clockwise};
use super::project::{Corners, Projection, is_inside, project, transpose_corners};
use super::small::{MAX_SMALL_TEXELS, SmallTriangle};
use super::wide::{F32s, Ints, LANE_INDICES, LANES};

/// Piece of a face's opaque triangles after set-up, sorted by the bands that they touch.
#[derive(Debug, Default)]
pub(super) struct OpaquePiece {
    pub large: Vec<LargeTriangle>,
    /// Small triangles in each band.
    pub small_by_band: Vec<Vec<SmallTriangle>>,
    /// Indices in `large` of the triangles in each band.
    pub large_by_band: Vec<Vec<u32>>,
}

/// Task that sets up some triangles.
pub(super) struct SetUp<'a> {
    pub piece: &'a mut OpaquePiece,
    pub triangles: Triangles<'a>,
    pub projection: &'a Projection,
}

/// Triangles to set up.
pub(super) enum Triangles<'a> {
    /// Triangles of a map, drawn from both sides.
    Listed(&'a [RasterTriangle]),
    /// Triangles of a picture.
    Indexed {
        clip_positions: &'a [[f32; 4]],
        /// Three per triangle.
        indices: &'a [u32],
        /// Index of the first one.
        first: usize,
        /// One bit per triangle of the scene; see [`super::VisibleTriangles`].
        both_sides: &'a [u32],
    },
}

/// Up to sixteen triangles.
struct Group {
    triangles: [RasterTriangle; LANES],
    count: usize,
    /// Number of the first one; the others follow.
    first_id: u32,
    /// Condition that holds in lanes whose triangles are drawn from both sides, not only where they are
    /// counter-clockwise.
    both_sides: Ints,
}

impl Triangles<'_> {
    fn count(&self) -> usize {
        match self {
            Self::Listed(triangles) => triangles.len(),
            Self::Indexed { indices, .. } => indices.len() / 3,
        }
    }

    /// Copies the triangles from `from` on into a group. It has no arithmetic, so one copy serves every processor.
    #[inline(never)]
    fn fetch(&self, from: usize, group: &mut Group) {
        group.count = (self.count() - from).min(LANES);
        match *self {
            Self::Listed(triangles) => {
                group.triangles[..group.count].copy_from_slice(&triangles[from..from + group.count]);
            }
            Self::Indexed { clip_positions, indices, first, both_sides } => {
                let corners = indices.as_chunks::<3>().0[from..from + group.count].iter();
                for (lane, corners) in corners.enumerate() {
                    group.triangles[lane] = corners.map(|corner| clip_positions[corner as usize]);
                    let has_both = has_both_sides(both_sides, first + from + lane);
                    group.both_sides.0[lane] = if has_both { 0 } else { -1 };
                }
                // An id is the index + 1.
                group.first_id = (first + from) as u32 + 1;
            }
        }
    }
}

/// True if a triangle is seen from both sides.
pub(super) fn has_both_sides(both_sides: &[u32], triangle: usize) -> bool {
    both_sides[triangle / 32] >> (triangle % 32) & 1 != 0
}

impl WithSimd for SetUp<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { piece, triangles, projection } = self;
        piece.clear(projection.band_count());
        let triangles_at_zero = [[[0.0; 4]; 3]; LANES];
        let mut group = Group { triangles: triangles_at_zero, count: 0, first_id: 0, both_sides: Ints::ZERO };
        let mut done = 0;
        while done < triangles.count() {
            triangles.fetch(done, &mut group);
            set_up_group(piece, &group, projection);
            done += LANES;
        }
    }
}

impl OpaquePiece {
    fn clear(&mut self, bands: usize) {
        self.large.clear();
        self.small_by_band.resize_with(bands, Vec::new);
        self.small_by_band.iter_mut().for_each(Vec::clear);
        self.large_by_band.resize_with(bands, Vec::new);
        self.large_by_band.iter_mut().for_each(Vec::clear);
    }

    fn add_large(&mut self, corners: [Corner; 3], id: u32, both_sides: bool, projection: &Projection) {
        if !both_sides && is_clockwise(&corners) {
            return;
        }
        let Some(mut large) = LargeTriangle::new(corners, projection.size) else { return };
        large.id = id;
        for band in projection.bands_of(large.rows) {
            self.large_by_band[band].push(self.large.len() as u32);
        }
        self.large.push(large);
    }

    fn add_cut(&mut self, triangle: [ClipCorner<4>; 3], id: u32, both_sides: bool, projection: &Projection) {
        let polygon = Polygon::clip(triangle, projection.least_w, projection.guard);
        for corners in polygon.triangles() {
            self.add_large(corners.map(|corner| projection.corner(corner)), id, both_sides, projection);
        }
    }
}

/// Returns the first and the last texel center between the least and the greatest of three coordinates, limited to the
/// face. Also returns a condition that holds in lanes in which these coordinates are close enough for a small triangle.
#[inline(always)]
fn span(p: Ints, q: Ints, r: Ints, side: usize) -> ([Ints; 2], Ints) {
    let [least, most] = [p.least(q).least(r), p.greatest(q).greatest(r)];
    let first = (least + Ints::splat(255)).whole_texels().greatest(Ints::splat(0));
    let last = most.whole_texels().least(Ints::splat(side as i32 - 1));
    ([first, last], Ints::splat(256 * MAX_SMALL_TEXELS) - (most - least))
}

/// Sets up triangles, and adds those that may cover a texel to a piece.
#[inline(always)]
fn set_up_group(piece: &mut OpaquePiece, group: &Group, projection: &Projection) {
    let Group { ref triangles, count, first_id, both_sides } = *group;
    let [a, b, c] = transpose_corners(triangles);
    let corners = [project(&a, projection), project(&b, projection), project(&c, projection)];
    let is_whole = is_inside(&corners[0], projection)
        | is_inside(&corners[1], projection)
        | is_inside(&corners[2], projection)
        | (Ints::splat(count as i32 - 1) - LANE_INDICES);
    let [p, q, r] = [corners[0].at, corners[1].at, corners[2].at];
    let (columns, is_narrow) = span(p[0], q[0], r[0], projection.size[0]);
    let (rows, is_low) = span(p[1], q[1], r[1], projection.size[1]);
    let is_seen = (columns[1] - columns[0]) | (rows[1] - rows[0]);
    let (smalls, covers, is_counter_clockwise) = small_ones(&corners, columns, rows);
    let smalls = SmallTriangle { id: first_id, ..smalls };
    let shows_side = both_sides.select(Ints::ZERO, is_counter_clockwise);
    let is_drawn = is_whole | is_seen | is_narrow | is_low | covers | shows_side;
    for lane in 0..count {
        if is_drawn.0[lane] >= 0 {
            let small = smalls.lane(lane);
            for band in projection.bands_of(small.rows) {
                piece.small_by_band[band].push(small);
            }
        } else if is_whole.0[lane] < 0 {
            let corners = corners.map(|corner| corner.clip.map(|x| x.0[lane]));
            piece.add_cut(corners, first_id + lane as u32, both_sides.0[lane] >= 0, projection);
        } else if is_seen.0[lane] >= 0 && (is_narrow.0[lane] < 0 || is_low.0[lane] < 0) {
            let corners = corners.map(|corner| Corner {
                at: corner.at.map(|x| x.0[lane]),
                n: corner.n.0[lane],
                d: corner.d.0[lane],
            });
            piece.add_large(corners, first_id + lane as u32, both_sides.0[lane] >= 0, projection);
        }
    }
}

/// Sets up sixteen triangles as small ones. `columns` and `rows` are the first and last texel centers in their bounding
/// boxes. Also returns a condition that holds in lanes whose triangle may cover a texel, and one that holds in lanes with
/// counter-clockwise triangles.
#[inline(always)]
fn small_ones(corners: &[Corners; 3], columns: [Ints; 2], rows: [Ints; 2]) -> (SmallTriangle<Ints, F32s>, Ints, Ints) {
    let [p, q, r] = [corners[0].at, corners[1].at, corners[2].at];
    let area = (q[0] - p[0]) * (r[1] - p[1]) - (r[0] - p[0]) * (q[1] - p[1]);
    let origin = [columns[0] * Ints::splat(256), rows[0] * Ints::splat(256)];
    let first = edges(q, r, area, origin);
    let second = edges(r, p, area, origin);
    let third = edges(p, q, area, origin);
    let is_counter_clockwise = -area;
    let area = area.select(area, -area);
    let per_area = F32s::splat(1.0) / area.floats();
    let rests = [second.rest, third.rest];
    let smalls = SmallTriangle {
        columns,
        rows,
        e: [first.e, second.e, third.e],
        a: [first.a, second.a, third.a],
        b: [first.b, second.b, third.b],
        n: plane(corners[0].n, corners[1].n, corners[2].n, per_area, rests),
        d: plane(corners[0].d, corners[1].d, corners[2].d, per_area, rests),
        id: 0,
    };
    // For many tiny triangles only one texel is in question, and one test answers it.
    let more = (columns[1] - columns[0]) + (rows[1] - rows[0]) - Ints::splat(1);
    let has_first = first.e | second.e | third.e;
    (smalls, (area - Ints::splat(1)) | more.select(more, has_first), is_counter_clockwise)
}

/// Edge functions like those of `SmallTriangle`. `rest` is the value at the first texel center before the division by
/// 256, less 256 times the value after it.
#[derive(Clone, Copy)]
struct Edges {
    e: Ints,
    a: Ints,
    b: Ints,
    rest: F32s,
}

/// Sets up the edge functions of the edges between two corners. `area` is the doubled signed area of each triangle.
#[inline(always)]
fn edges(from: [Ints; 2], to: [Ints; 2], area: Ints, origin: [Ints; 2]) -> Edges {
    let (a, b) = (from[1] - to[1], to[0] - from[0]);
    let (a, b) = (area.select(a, -a), area.select(b, -b));
    let start = a * (origin[0] - from[0]) + b * (origin[1] - from[1]);
    // Centers on top and left edges are covered: where a > 0, or a = 0 and b > 0.
    let is_flat = a | -a;
    let uncovered = is_flat.select(Ints::splat(1) - b, Ints::splat(1) - a);
    let uncovered = (-uncovered).select(Ints::ZERO, Ints::splat(1));
    let e = (start - uncovered).whole_texels();
    Edges { e, a, b, rest: (start - e * Ints::splat(256)).floats() }
}

/// Makes the coefficients of N or D of a `SmallTriangle` from its values at the three corners.
#[inline(always)]
fn plane(x: F32s, second: F32s, third: F32s, per_area: F32s, rests: [F32s; 2]) -> [F32s; 3] {
    let (one, two) = ((second - x) * per_area, (third - x) * per_area);
    let start = rests[1].times_plus(two, rests[0].times_plus(one, x));
    [start, one * F32s::splat(256.0), two * F32s::splat(256.0)]
}

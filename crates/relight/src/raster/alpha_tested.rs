//! Triangles with alpha tests. A texel whose alpha is below the test's cutoff is a hole, and stores nothing.
#![expect(clippy::cast_possible_wrap, reason = "positions on a map are far below 2^31")]

use glam::Vec3;

use super::clip::Polygon;
use super::ids::TriangleIds;
use super::large::{LargeTriangle, Plane, is_clockwise};
use super::project::Projection;
use super::rule::DepthTest;
use super::wide::{F32s, Ints, LANES};
use super::{AlphaTestedTriangle, Band};
use crate::alpha_test::AlphaTests;

/// Alpha-tested triangle, set up.
#[derive(Debug)]
struct AlphaTestedLarge {
    large: LargeTriangle,
    /// Planes of u / w, v / w and alpha / w.
    over_w: [Plane; 3],
    test: usize,
}

/// Piece of a face's alpha-tested triangles after set-up, sorted by the bands that they touch.
#[derive(Debug, Default)]
pub(super) struct AlphaTestedPiece {
    triangles: Vec<AlphaTestedLarge>,
    /// Indices in `triangles` of the triangles in each band.
    in_bands: Vec<Vec<u32>>,
}

impl AlphaTestedPiece {
    /// Sets up these triangles, and discards the former ones.
    pub fn set_up(&mut self, triangles: &[AlphaTestedTriangle], projection: &Projection) {
        self.clear(projection);
        for triangle in triangles {
            self.add(triangle, 0, true, projection);
        }
    }

    /// Discards all triangles.
    pub fn clear(&mut self, projection: &Projection) {
        self.triangles.clear();
        self.in_bands.resize_with(projection.band_count(), Vec::new);
        self.in_bands.iter_mut().for_each(Vec::clear);
    }

    /// Sets up a triangle with this number.
    pub fn add(&mut self, triangle: &AlphaTestedTriangle, id: u32, both_sides: bool, projection: &Projection) {
        let corners: [[f32; 7]; 3] = std::array::from_fn(|k| {
            let ([x, y, w, value], [u, v, alpha]) = (projection.clip(triangle.corners[k]), triangle.uv_alpha[k]);
            [x, y, w, value, u, v, alpha]
        });
        for corners in Polygon::clip(corners, projection.least_w, projection.guard).triangles() {
            let over_w = [4, 5, 6].map(|axis| corners.map(|corner| f64::from(corner[axis]) / f64::from(corner[2])));
            let on_face = corners.map(|[x, y, w, value, ..]| projection.corner([x, y, w, value]));
            if !both_sides && is_clockwise(&on_face) {
                continue;
            }
            let Some((mut large, over_w)) = LargeTriangle::with_planes(on_face, over_w, projection.size) else {
                continue;
            };
            large.id = id;
            for band in projection.bands_of(large.rows) {
                self.in_bands[band].push(self.triangles.len() as u32);
            }
            self.triangles.push(AlphaTestedLarge { large, over_w, test: triangle.test as usize });
        }
    }

    /// Returns the number of triangles in a band.
    pub fn count_in(&self, band: usize) -> usize {
        self.in_bands[band].len()
    }

    /// Draws one triangle of a band, and returns the number of texels in its bounding box.
    #[inline(always)]
    pub fn draw<R: DepthTest, Ids: TriangleIds>(
        &self,
        rule: R,
        tests: AlphaTests,
        index: usize,
        triangle: usize,
        band: &mut Band<Ids>,
    ) -> usize {
        let alpha_tested = &self.triangles[self.in_bands[index][triangle] as usize];
        let large = &alpha_tested.large;
        let texel_count = large.texels_in(band);
        let first = (large.rows[0] as usize).max(band.first);
        let end = (large.rows[1] as usize + 1).min(band.end);
        let of_rule = rule.triangle(large.id);
        for row in first..end {
            let Some(run) = large.run(row) else { continue };
            let in_row = rule.row(of_rule, row);
            let at = (row - band.first) * band.stride + run.first;
            let mut done = 0;
            while done < run.count {
                let Some(texels) = band.texels[at + done..].first_chunk_mut::<LANES>() else { return texel_count };
                let (covered, n, d) = run.lanes_from(done, band.lane_indices);
                let columns = band.lane_indices + Ints::splat((run.first + done) as i32);
                let stored = rule.updated_depths(covered, n, d, in_row, columns, F32s(*texels));
                let before = F32s(*texels);
                for (lane, texel) in texels.iter_mut().enumerate() {
                    // A texel that a nearer triangle hides needs no test.
                    if stored.0[lane] != *texel && !alpha_tested.is_hole(tests, run.first + done + lane, row) {
                        *texel = stored.0[lane];
                    }
                }
                band.ids.note(at + done, before, F32s(*texels), large.id);
                done += LANES;
            }
        }
        texel_count
    }
}

impl AlphaTestedLarge {
    /// True if the triangle has a hole at a texel's center. One copy serves every processor and every rule.
    #[inline(never)]
    fn is_hole(&self, tests: AlphaTests, column: usize, row: usize) -> bool {
        let (d, over_w) = self.large.at(&self.over_w, column, row);
        tests.is_hole(self.test, Vec3::from(over_w.map(|x| (x / d) as f32)))
    }
}

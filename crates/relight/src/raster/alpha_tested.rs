//! Triangles with alpha tests. A texel whose alpha is below the test's cutoff is a hole, and stores nothing.

use glam::Vec3;

use super::clip::Polygon;
use super::large::{LargeTriangle, Plane};
use super::project::Projection;
use super::rule::DepthTest;
use super::wide::{F32s, LANES};
use super::{AlphaTestedTriangle, BAND, Band};
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
        self.triangles.clear();
        self.in_bands.resize_with(projection.side.div_ceil(BAND), Vec::new);
        self.in_bands.iter_mut().for_each(Vec::clear);
        for triangle in triangles {
            self.add(triangle, projection);
        }
    }

    fn add(&mut self, triangle: &AlphaTestedTriangle, projection: &Projection) {
        let corners: [[f32; 7]; 3] = std::array::from_fn(|k| {
            let ([x, y, w, value], [u, v, alpha]) = (projection.clip(triangle.corners[k]), triangle.uv_alpha[k]);
            [x, y, w, value, u, v, alpha]
        });
        for corners in Polygon::clip(corners, projection.least_w, projection.guard).triangles() {
            let over_w = [4, 5, 6].map(|axis| corners.map(|corner| f64::from(corner[axis]) / f64::from(corner[2])));
            let on_face = corners.map(|[x, y, w, value, ..]| projection.corner([x, y, w, value]));
            let Some((large, over_w)) = LargeTriangle::with_planes(on_face, over_w, projection.side) else {
                continue;
            };
            let [first, last] = large.rows.map(|row| row as usize / BAND);
            for band in first..=last {
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
    pub fn draw<R: DepthTest>(
        &self,
        rule: R,
        tests: AlphaTests,
        index: usize,
        triangle: usize,
        band: &mut Band,
    ) -> usize {
        let alpha_tested = &self.triangles[self.in_bands[index][triangle] as usize];
        let large = &alpha_tested.large;
        let texel_count = large.texels_in(band);
        let first = (large.rows[0] as usize).max(band.first);
        let end = (large.rows[1] as usize + 1).min(band.end);
        for row in first..end {
            let Some(run) = large.run(row) else { continue };
            let at = (row - band.first) * band.stride + run.first;
            let mut done = 0;
            while done < run.count {
                let Some(texels) = band.texels[at + done..].first_chunk_mut::<LANES>() else { return texel_count };
                let (covered, n, d) = run.lanes_from(done, band.lane_indices);
                let stored = rule.updated_depths(covered, n, d, rule.row_factor(row), F32s(*texels));
                for (lane, texel) in texels.iter_mut().enumerate() {
                    // A texel that a nearer triangle hides needs no test.
                    if stored.0[lane] != *texel && !alpha_tested.is_hole(tests, run.first + done + lane, row) {
                        *texel = stored.0[lane];
                    }
                }
                done += LANES;
            }
        }
        texel_count
    }
}

impl AlphaTestedLarge {
    /// True if the triangle has a hole at a texel's center.
    #[inline(always)]
    fn is_hole(&self, tests: AlphaTests, column: usize, row: usize) -> bool {
        let (d, over_w) = self.large.at(&self.over_w, column, row);
        tests.is_hole(self.test, Vec3::from(over_w.map(|x| (x / d) as f32)))
    }
}

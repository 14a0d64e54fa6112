//! Drawing of a bent map's triangles with their edges, to show their density and position; like `wireframe.wgsl`.

use glam::DVec3;

use super::map::BentMapBuilder;
use crate::raster::RasterTriangle;
use crate::{Cancelled, Workers};

/// Rows that a worker draws at once.
const ROWS_PER_BAND: usize = 16;

/// Picture of a map's triangles: v to the right, w upwards, from -1 to 1 over the shorter side.
#[derive(Clone, Copy, Debug)]
pub struct Wireframe {
    /// Width and height in pixels.
    pub size: [usize; 2],
    /// The t of the whole light where the drawn part begins, and its change per t of the part.
    pub t_of_light: [f64; 2],
    /// The part's t of depth 0, and the difference to that of depth 1.
    pub t_base: f64,
    pub t_span: f64,
}

/// Triangle ready to be drawn. A pixel's clip coordinates (x, y, 1), times each of `edges`, are its weights times a
/// common factor, which is positive in front of the viewer.
struct DrawnTriangle {
    edges: [DVec3; 3],
    /// Map's t of the corners.
    t: [f64; 3],
    /// First column and row, and those after the last.
    bounds: [[usize; 2]; 2],
}

impl BentMapBuilder {
    /// Draws the triangles that [`Self::map_triangles`] and [`Self::split`] made: t in red, 1 on an edge in green, 1 in
    /// alpha. Of several at a pixel, the one of least t is shown. Alpha tests are ignored. `picture` has rows from the top.
    pub fn draw_wireframe(
        &self,
        workers: &Workers,
        wireframe: &Wireframe,
        picture: &mut [[f32; 4]],
    ) -> Result<(), Cancelled> {
        let triangles: Vec<_> = self.triangles().filter_map(|corners| wireframe.set_up(corners)).collect();
        let [width, _] = wireframe.size;
        workers.each(picture.chunks_mut(ROWS_PER_BAND * width).enumerate(), |(band, pixels)| {
            let first = *band * ROWS_PER_BAND;
            let last = first + pixels.len() / width;
            pixels.fill([0.0; 4]);
            let mut depths = vec![1.0; pixels.len()];
            for triangle in &triangles {
                let [[left, top], [right, bottom]] = triangle.bounds;
                for y in top.max(first)..bottom.min(last) {
                    for x in left..right {
                        let at = (y - first) * width + x;
                        wireframe.draw(triangle, [x, y], &mut depths[at], &mut pixels[at]);
                    }
                }
            }
            true
        })
    }
}

impl Wireframe {
    fn set_up(&self, corners: &RasterTriangle) -> Option<DrawnTriangle> {
        let size = self.size.map(|side| side as f64);
        let shorter = size[0].min(size[1]);
        let clip = corners.map(|[v, w, r, _]| {
            DVec3::new(f64::from(v) * shorter / size[0], f64::from(w) * shorter / size[1], f64::from(r))
        });
        let determinant = clip[0].dot(clip[1].cross(clip[2]));
        if determinant == 0.0 || !determinant.is_finite() {
            return None;
        }
        let edges = [1, 2, 0].map(|k| clip[k].cross(clip[(k + 1) % 3]) / determinant);
        let mut bounds = [[0; 2], self.size];
        if clip.iter().all(|corner| corner.z > 0.0) {
            for axis in 0..2 {
                // Rows count downwards.
                let sign = if axis == 0 { 1.0 } else { -1.0 };
                let at = clip.map(|corner| (sign * corner[axis] / corner.z * 0.5 + 0.5) * size[axis]);
                let least = at.into_iter().fold(f64::INFINITY, f64::min);
                let most = at.into_iter().fold(f64::NEG_INFINITY, f64::max);
                bounds[0][axis] = least.floor().clamp(0.0, size[axis]) as usize;
                bounds[1][axis] = most.ceil().clamp(0.0, size[axis]) as usize;
            }
        }
        Some(DrawnTriangle { edges, t: corners.map(|corner| f64::from(corner[3])), bounds })
    }

    fn draw(&self, triangle: &DrawnTriangle, [x, y]: [usize; 2], depth: &mut f64, pixel: &mut [f32; 4]) {
        let [width, height] = self.size.map(|side| side as f64);
        let (right, down) = (2.0 / width, -2.0 / height);
        let at = DVec3::new((x as f64 + 0.5) * right - 1.0, (y as f64 + 0.5) * down + 1.0, 1.0);
        let scaled = triangle.edges.map(|edge| edge.dot(at));
        let sum: f64 = scaled.iter().sum();
        if !(scaled.iter().all(|weight| *weight >= 0.0) && sum > 0.0) {
            return;
        }
        let weights = scaled.map(|weight| weight / sum);
        let t = weights[0] * triangle.t[0] + weights[1] * triangle.t[1] + weights[2] * triangle.t[2];
        if t / self.t_span > *depth {
            return;
        }
        *depth = t / self.t_span;
        // A weight's change from one pixel to the next, to the right and downwards. A line fades over half a pixel to
        // each side.
        let all = triangle.edges[0] + triangle.edges[1] + triangle.edges[2];
        let distance = |k: usize| {
            let change = (triangle.edges[k] - all * weights[k]) / sum;
            weights[k] / ((change.x * right).abs() + (change.y * down).abs()).max(1e-30)
        };
        let nearest = distance(0).min(distance(1)).min(distance(2));
        let edge = (1.0 - 2.0 * nearest).clamp(0.0, 1.0);
        let t_of_light = self.t_of_light[0] + self.t_of_light[1] * (t + self.t_base);
        *pixel = [t_of_light as f32, edge as f32, 0.0, 1.0];
    }
}

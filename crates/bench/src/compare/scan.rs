//! Finds crossings of scan lines with shadow edges, in the reference and in the picture.

use rayon::prelude::*;
use render::Picture;

use super::ExpectedPicture;
use super::crossing::{Crossing, ScanAxis};
use super::expected::ExpectedPixel;

/// Factor of the size at which the picture's visibility is drawn, so that its edges are known to a sixth of a pixel. It
/// is odd, so that the center of every pixel is one of its points.
pub(super) const FINER: u32 = 3;
/// Distance in pixels on both sides of a crossing within which the picture's edge is searched.
const WINDOW: f64 = 6.0;
/// Number of times that a pixel's width is halved. After that an edge is known to 2^-12 of the width.
const HALVINGS: u32 = 12;
/// Greatest distance of one pixel's surface from the plane of the adjacent pixel's, as a share of the distance between
/// them, at which both count as one surface.
const COPLANAR: f64 = 0.3;
/// Minimum radiance of light that ends at an edge, as a share of the brightest. Less than that is not seen to end, at
/// the rim of a light or along a terminator.
const VISIBLE: f64 = 0.01;

impl ExpectedPicture<'_> {
    /// Finds all crossings of rows and columns.
    pub(super) fn find_crossings(&self) -> Vec<Crossing> {
        let (width, height) = self.size();
        let rows = (0..height).map(|row| (ScanAxis::Row, row, width));
        let columns = (0..width).map(|column| (ScanAxis::Column, column, height));
        let lines: Vec<_> = rows.chain(columns).collect();
        let radiances = self.pixels.iter().flatten().map(|seen| seen.radiance().max_element());
        let least = VISIBLE * radiances.fold(0.0, f64::max);
        let on_line = |&(axis, line, length): &(ScanAxis, usize, usize)| {
            (1..length).filter_map(move |along| self.crossing(axis, line, along, least))
        };
        lines.par_iter().flat_map_iter(on_line).collect()
    }

    /// Finds the edge between the pixels `along - 1` and `along` of a line, if both show one surface and radiance of at
    /// least `least` ends there.
    fn crossing(&self, axis: ScanAxis, line: usize, along: usize, least: f64) -> Option<Crossing> {
        let width = self.size().0;
        let seen = |along: usize| self.pixels[axis.index(width, line, along)].as_ref();
        let (before, after) = (seen(along - 1)?, seen(along)?);
        let falls = before.lit()?;
        let lit = if falls { before } else { after };
        let seen_to_end = lit.radiance().max_element() >= least;
        if falls == after.lit()? || !on_one_surface(before, after) || !seen_to_end {
            return None;
        }
        let line_at = line as f64;
        let at = self.edge_between(axis, line_at, [along as f64 - 0.5, along as f64 + 0.5], falls)?;
        // If the edge runs nearly along this axis, the other axis crosses it.
        let beside = self.edge_between(axis, line_at + 0.25, [at - 1.0, at + 1.0], falls)?;
        let squareness = 0.25 / (beside - at).hypot(0.25);
        Some(Crossing { axis, line, at, squareness, light_ends: falls })
    }

    /// Returns the position on a line, between two others, at which the light ends or begins; `None` if it does not.
    fn edge_between(&self, axis: ScanAxis, line: f64, [mut low, mut high]: [f64; 2], falls: bool) -> Option<f64> {
        let lit = |along: f64| self.seen(axis.point(line, along))?.lit();
        if lit(low)? != falls || lit(high)? == falls {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(low, high);
            if lit(middle)? == falls { low = middle } else { high = middle }
        }
        Some(f64::midpoint(low, high))
    }

    /// Returns the distance in pixels from each crossing to the picture's edge, which the same line crosses in the same
    /// sense; infinity if farther than [`WINDOW`] along the line.
    pub(super) fn displacements(&self, fine_visibility: &Picture) -> Vec<f64> {
        self.crossings.par_iter().map(|crossing| displacement(crossing, fine_visibility)).collect()
    }
}

fn on_one_surface(a: &ExpectedPixel, b: &ExpectedPixel) -> bool {
    let step = b.surface.position - a.surface.position;
    a.surface.node == b.surface.node && step.dot(a.surface.geometric_normal).abs() <= COPLANAR * step.length()
}

fn displacement(crossing: &Crossing, fine: &Picture) -> f64 {
    let Crossing { axis, line, at, squareness, light_ends: falls } = *crossing;
    let finer = FINER as usize;
    let (width, height) = (fine.width as usize, fine.height as usize);
    let length = if axis == ScanAxis::Row { width } else { height };
    let fine_line = line * finer + finer / 2;
    let share = |along: usize| {
        let [share, .., inside] = fine.pixels[axis.index(width, fine_line, along)];
        (inside > 0.0).then_some(f64::from(share))
    };
    let bound = |pixels: f64| (pixels * f64::from(FINER)).clamp(1.0, length as f64) as usize;
    let crosses = |along: usize| {
        let (before, after) = (share(along - 1)?, share(along)?);
        let found = if falls { before >= 0.5 && after < 0.5 } else { before < 0.5 && after >= 0.5 };
        let part = (before - 0.5) / (before - after);
        found.then(|| (along as f64 - 0.5 + part) / f64::from(FINER))
    };
    let found = (bound(at - WINDOW)..bound(at + WINDOW)).filter_map(crosses);
    found.map(|found| (found - at).abs() * squareness).fold(f64::INFINITY, f64::min)
}

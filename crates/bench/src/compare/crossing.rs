//! Intersection of a line of pixels with a shadow edge.

use glam::DVec2;

/// Direction of a line through pixel centers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScanAxis {
    Row,
    Column,
}

/// Position at which a scan line crosses a shadow edge in the reference's picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub axis: ScanAxis,
    /// Index of the row or column.
    pub line: usize,
    /// Pixels along the line.
    pub at: f64,
    /// Sine of the angle between the line and the edge.
    pub squareness: f64,
    /// True if the light ends at the edge, false if it begins.
    pub light_ends: bool,
}

impl ScanAxis {
    /// Returns the point of the picture at `along` pixels on a line.
    pub fn point(self, line: f64, along: f64) -> DVec2 {
        let across = line + 0.5;
        match self {
            Self::Row => DVec2::new(along, across),
            Self::Column => DVec2::new(across, along),
        }
    }

    /// Returns the index of the pixel `along` a line, in a picture that is `width` pixels wide.
    pub fn index(self, width: usize, line: usize, along: usize) -> usize {
        match self {
            Self::Row => line * width + along,
            Self::Column => along * width + line,
        }
    }
}

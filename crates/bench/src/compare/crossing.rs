//! A place where a line of pixels crosses a shadow's edge.

use glam::DVec2;

/// A line of pixels' centres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScanAxis {
    Row,
    Column,
}

/// Where a scan line crosses a shadow's edge by the reference.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub axis: ScanAxis,
    /// Which row or column.
    pub line: usize,
    /// Pixels along it.
    pub at: f64,
    /// Sine of the angle between the line and the edge.
    pub squareness: f64,
    /// Whether the light ends there rather than begins.
    pub light_ends: bool,
}

impl ScanAxis {
    /// The point of the picture that is `along` a line, in pixels.
    pub fn point(self, line: f64, along: f64) -> DVec2 {
        let across = line + 0.5;
        match self {
            Self::Row => DVec2::new(along, across),
            Self::Column => DVec2::new(across, along),
        }
    }

    /// The index in a picture of `width` of the pixel `along` a line.
    pub fn index(self, width: usize, line: usize, along: usize) -> usize {
        match self {
            Self::Row => line * width + along,
            Self::Column => along * width + line,
        }
    }
}

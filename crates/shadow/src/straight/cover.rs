//! Parts of the faces of perspective maps that casters cover.

use glam::DVec2;

use crate::casters::MapCover;
use crate::settings::SMALLEST_RATIO;

/// Drawn part of a face of a map, as x / depth and y / depth.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FittedFace {
    pub center: DVec2,
    /// Half the size of the drawn part.
    pub half: DVec2,
    /// False if there are no casters: the face need not be drawn.
    pub has_casters: bool,
}

impl FittedFace {
    /// Returns the center and 1 / half size, as lookups read them.
    pub fn for_lookup(&self) -> [f32; 4] {
        let scale = self.half.recip();
        [self.center.x, self.center.y, scale.x, scale.y].map(|x| x as f32)
    }
}

/// Part of a face that boxes cover.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceCover {
    pub low: DVec2,
    pub high: DVec2,
    /// Least depth; infinity without boxes.
    pub nearest: f64,
}

impl FaceCover {
    pub const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, nearest: f64::INFINITY };

    /// Fits the drawn part of a face from `low` to `high` to the cover, `grown` by the share that the filter reads
    /// beyond an edge. `smallest` is its smallest half size.
    pub fn fitted(&self, [low, high]: [DVec2; 2], grown: f64, smallest: f64) -> FittedFace {
        let (middle, widest) = ((low + high) / 2.0, (high - low) / 2.0 * grown);
        let has_casters = self.nearest < f64::INFINITY;
        let (low, high) = if has_casters { (self.low, self.high) } else { (low, high) };
        let half = (high - low) / 2.0;
        let least = (half.max_element() * SMALLEST_RATIO).max(smallest);
        let half = (half.max(DVec2::splat(least)) * grown).min(widest);
        // Grown, but no farther than the filter reads beyond the face.
        let room = widest - half;
        FittedFace { center: ((low + high) / 2.0).clamp(middle - room, middle + room), half, has_casters }
    }
}

impl MapCover for FaceCover {
    fn contains(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all() && self.nearest <= other.nearest
    }

    fn extend(&mut self, other: &Self) {
        (self.low, self.high) = (self.low.min(other.low), self.high.max(other.high));
        self.nearest = self.nearest.min(other.nearest);
    }
}

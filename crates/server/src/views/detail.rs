//! Detail of a view's moving pictures, chosen from their times so that they keep their rate. Knows no clock.
//!
//! The expected time at another detail is the current time multiplied by a ratio. The ratio is estimated from texels
//! and pixels at first, and measured once the other detail was tried. Of the details that are expected to be fast
//! enough, the finest is chosen. The threshold for a finer detail is below the one for a coarser detail, so a steady
//! load keeps its detail.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use protocol::{Interaction, Reduction};
use render::MapScale;

/// Greatest time that drawing and encoding a moving picture should take.
const TARGET_TIME: Duration = Duration::from_millis(33);
/// Share of the target time below which the expected time of a finer detail must be, so that the change to it is not
/// soon reverted.
const HEADROOM: f64 = 0.75;
/// Least time between two changes of a view's detail.
const MIN_CHANGE_INTERVAL: Duration = Duration::from_secs(1);
/// Number of latest pictures whose median time decides about a change. The median ignores a single slow picture.
const MAX_SAMPLES: usize = 8;
/// Number of pictures of one detail that must be measured before another detail is chosen.
const MIN_SAMPLES: usize = 3;
/// Time without a moving picture after which the measured times are no longer trusted, because the machine's load may
/// have changed.
const HISTORY_LIFETIME: Duration = Duration::from_secs(1);

/// Side lengths of a moving picture, as a share of the view's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    Full,
    ThreeQuarters,
    Half,
}

/// Quality of a moving picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    pub shadow_map: MapScale,
    pub resolution: Resolution,
}

/// A finished moving picture.
#[derive(Clone, Copy, Debug)]
pub struct TimedPicture {
    pub detail: Detail,
    /// Time that drawing and encoding the picture took.
    pub took: Duration,
    /// True if a shadow map was drawn for the picture. Otherwise a coarser map would save nothing.
    pub drew_map: bool,
}

/// The detail of a view's moving pictures and its history.
#[derive(Clone, Debug)]
pub struct DetailChoice {
    interaction: Interaction,
    detail: Detail,
    changed_at: Option<Instant>,
    /// Latest pictures of this detail: seconds, and true if a shadow map was drawn.
    latest: VecDeque<(f64, bool)>,
    last_recorded_at: Option<Instant>,
    /// Expected time of a picture at each of [`Detail::ALL`], as a ratio to the time at full detail.
    ratios: [f64; Detail::ALL.len()],
    /// Detail before the latest change, and the seconds per picture at it, until the effect of the change is measured.
    previous: Option<(Detail, f64)>,
}

impl Resolution {
    /// Returns the size `[width, height]` of a picture for a view of size `size`.
    pub fn of(self, size: [u32; 2]) -> [u32; 2] {
        size.map(|side| ((f64::from(side) * self.side_ratio()).round() as u32).max(1))
    }

    fn side_ratio(self) -> f64 {
        match self {
            Self::Full => 1.0,
            Self::ThreeQuarters => 0.75,
            Self::Half => 0.5,
        }
    }
}

impl Detail {
    pub const FULL: Self = Self::ALL[0];

    /// All details, in the order of preference: edges of shadows become softer before the whole picture does.
    const ALL: [Self; 6] = {
        use MapScale::{Full, Half};
        [
            Self { shadow_map: Full, resolution: Resolution::Full },
            Self { shadow_map: Half, resolution: Resolution::Full },
            Self { shadow_map: Full, resolution: Resolution::ThreeQuarters },
            Self { shadow_map: Half, resolution: Resolution::ThreeQuarters },
            Self { shadow_map: Full, resolution: Resolution::Half },
            Self { shadow_map: Half, resolution: Resolution::Half },
        ]
    };

    fn index(self) -> usize {
        Self::ALL.iter().position(|detail| *detail == self).unwrap_or_default()
    }

    fn is_allowed_by(self, interaction: Interaction) -> bool {
        let map = self.shadow_map == MapScale::Full || interaction.shadow_map == Reduction::Auto;
        let resolution = self.resolution == Resolution::Full || interaction.resolution == Reduction::Auto;
        map && resolution
    }

    /// Returns the number of texels of shadow maps, as a ratio to full maps.
    fn texel_ratio(self) -> f64 {
        let divisor = f64::from(self.shadow_map.divisor());
        1.0 / (divisor * divisor)
    }

    /// Returns the number of pixels, as a ratio to the full size.
    fn pixel_ratio(self) -> f64 {
        self.resolution.side_ratio() * self.resolution.side_ratio()
    }

    /// Returns the time that a picture is expected to take before anything is measured, as a ratio to the time at full
    /// detail. Half of the full time scales with the pixels, and a quarter with the texels of shadow maps.
    fn expected_time_ratio(self) -> f64 {
        (0.75 + 0.25 * self.texel_ratio()) * f64::midpoint(1.0, self.pixel_ratio())
    }
}

impl DetailChoice {
    /// Starts at full detail without measurements.
    pub fn new(interaction: Interaction) -> Self {
        Self {
            interaction,
            detail: Detail::FULL,
            changed_at: None,
            latest: VecDeque::new(),
            last_recorded_at: None,
            ratios: Detail::ALL.map(Detail::expected_time_ratio),
            previous: None,
        }
    }

    /// Returns the detail of the next moving picture.
    pub fn detail(&self) -> Detail {
        self.detail
    }

    /// Notes a finished moving picture and changes the detail if necessary.
    pub fn record_picture(&mut self, made: TimedPicture, now: Instant) {
        // Pictures that were begun before the change do not count.
        if made.detail != self.detail {
            return;
        }
        if self.last_recorded_at.is_some_and(|then| now.saturating_duration_since(then) > HISTORY_LIFETIME) {
            self.decay_ratios();
        }
        self.last_recorded_at = Some(now);
        self.latest.push_back((made.took.as_secs_f64(), made.drew_map));
        if self.latest.len() > MAX_SAMPLES {
            self.latest.pop_front();
        }
        if self.latest.len() < MIN_SAMPLES {
            return;
        }
        let seconds = median(self.latest.iter().map(|(seconds, _)| *seconds).collect());
        self.update_ratios(seconds);
        if self.changed_at.is_some_and(|then| now.saturating_duration_since(then) < MIN_CHANGE_INTERVAL) {
            return;
        }
        if let Some(detail) = self.next_detail(seconds) {
            self.previous = Some((self.detail, seconds));
            (self.detail, self.changed_at) = (detail, Some(now));
            self.latest.clear();
        }
    }

    /// Returns the detail to change to, if a picture of the current detail takes `seconds`.
    fn next_detail(&self, seconds: f64) -> Option<Detail> {
        let draws_maps = 2 * self.latest.iter().filter(|(_, drew_map)| *drew_map).count() > self.latest.len();
        let can_be = |detail: &Detail| {
            detail.is_allowed_by(self.interaction) && (draws_maps || detail.shadow_map == self.detail.shadow_map)
        };
        let (target, current) = (TARGET_TIME.as_secs_f64(), self.detail.index());
        let expected = |detail: Detail| seconds * self.ratios[detail.index()] / self.ratios[current];
        let (finer, coarser) = (&Detail::ALL[..current], &Detail::ALL[current + 1..]);
        if seconds <= target {
            return finer.iter().copied().find(|d| can_be(d) && expected(*d) <= HEADROOM * target);
        }
        let quicker = |d: &Detail| can_be(d) && expected(*d) < seconds;
        let enough = coarser.iter().copied().find(|d| quicker(d) && expected(*d) <= target);
        enough.or_else(|| coarser.iter().copied().rfind(quicker))
    }

    /// Notes the measured effect of the latest change.
    fn update_ratios(&mut self, seconds: f64) {
        let Some((before, took)) = self.previous.take() else { return };
        let ratio = (seconds / took).clamp(0.01, 100.0);
        if self.detail == Detail::FULL {
            self.ratios[before.index()] = 1.0 / ratio;
        } else {
            self.ratios[self.detail.index()] = self.ratios[before.index()] * ratio;
        }
    }

    /// Moves the ratios halfway back to the estimates after a time without movement.
    fn decay_ratios(&mut self) {
        self.latest.clear();
        self.previous = None;
        for (ratio, detail) in self.ratios.iter_mut().zip(Detail::ALL) {
            *ratio = f64::midpoint(*ratio, detail.expected_time_ratio());
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[cfg(test)]
mod tests;

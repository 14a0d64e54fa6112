//! How fine moving pictures of a view are: chosen from what they took, so that they hold their rate. Knows no clock.
//!
//! What a picture would take at another detail is what it takes now, times a ratio: at first one by texels and pixels,
//! once the other was tried what was measured. Where that says that a picture is quick enough, the finest such detail is
//! taken. There is room between what is too slow and what is quick enough for more, so that a steady load keeps its detail.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use protocol::{Interaction, Reduction};
use render::MapScale;

/// What a moving picture may take.
const TARGET_TIME: Duration = Duration::from_millis(33);
/// What a finer one has to be expected to take at most, of that: less, so that it is not taken back.
const HEADROOM: f64 = 0.75;
/// How long a detail is kept at least.
const MIN_CHANGE_INTERVAL: Duration = Duration::from_secs(1);
/// Pictures that it is chosen by: the latest so many, whose median a slow one does not move.
const MAX_SAMPLES: usize = 8;
/// As many of one detail have to have been seen before another is chosen.
const MIN_SAMPLES: usize = 3;
/// After so long without one, what was learnt may be of another load.
const HISTORY_LIFETIME: Duration = Duration::from_secs(1);

/// The sides of a moving picture, of those of its view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolution {
    Full,
    ThreeQuarters,
    Half,
}

/// How fine a moving picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Detail {
    pub shadow_map: MapScale,
    pub resolution: Resolution,
}

/// A moving picture that was made.
#[derive(Clone, Copy, Debug)]
pub struct TimedPicture {
    pub detail: Detail,
    /// Its render and its encoding.
    pub took: Duration,
    /// Whether a shadow map was drawn for it: else a coarser one would save nothing.
    pub drew_map: bool,
}

/// Which detail the moving pictures of a view have, and what that follows from.
#[derive(Clone, Debug)]
pub struct DetailChoice {
    interaction: Interaction,
    detail: Detail,
    changed_at: Option<Instant>,
    /// The latest pictures of this detail: seconds, and whether a map was drawn.
    latest: VecDeque<(f64, bool)>,
    last_recorded_at: Option<Instant>,
    /// What a picture takes at each of [`Detail::ALL`], of what it takes in full.
    ratios: [f64; Detail::ALL.len()],
    /// The detail before, and the seconds that a picture took then, until it is known what the change made of them.
    previous: Option<(Detail, f64)>,
}

impl Resolution {
    /// `[width, height]` of the picture of a view of that size.
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

    /// Every detail, first what is to be given up last: edges of shadows become softer before all of the picture does.
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

    /// The texels of maps, of those in full.
    fn texel_ratio(self) -> f64 {
        let divisor = f64::from(self.shadow_map.divisor());
        1.0 / (divisor * divisor)
    }

    /// The pixels, of those in full.
    fn pixel_ratio(self) -> f64 {
        self.resolution.side_ratio() * self.resolution.side_ratio()
    }

    /// What a picture is thought to take, of what it takes in full, before that was measured: half goes with its pixels, and a
    /// quarter of it with the texels of the maps.
    fn expected_time_ratio(self) -> f64 {
        (0.75 + 0.25 * self.texel_ratio()) * f64::midpoint(1.0, self.pixel_ratio())
    }
}

impl DetailChoice {
    /// Nothing has been made.
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

    /// What may be reduced.
    pub fn interaction(&self) -> Interaction {
        self.interaction
    }

    /// How fine the next moving picture is.
    pub fn detail(&self) -> Detail {
        self.detail
    }

    /// A moving picture was made.
    pub fn record_picture(&mut self, made: TimedPicture, now: Instant) {
        // One that was begun before the change.
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

    /// The detail to change to, where a picture of this one takes so many seconds.
    fn next_detail(&self, seconds: f64) -> Option<Detail> {
        let draws_maps = 2 * self.latest.iter().filter(|(_, drew_map)| *drew_map).count() > self.latest.len();
        let can_be = |detail: &Detail| {
            detail.is_allowed_by(self.interaction)
                && (draws_maps || detail.shadow_map == self.detail.shadow_map)
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

    /// Takes down what the latest change has made of what a picture takes.
    fn update_ratios(&mut self, seconds: f64) {
        let Some((before, took)) = self.previous.take() else { return };
        let ratio = (seconds / took).clamp(0.01, 100.0);
        if self.detail == Detail::FULL {
            self.ratios[before.index()] = 1.0 / ratio;
        } else {
            self.ratios[self.detail.index()] = self.ratios[before.index()] * ratio;
        }
    }

    /// Nothing has moved for a while: half of what was learnt is what is thought at first.
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

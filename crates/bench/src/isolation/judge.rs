//! Judges a row: computes frame rate, gaps and answer times of the victim, the client whose loss is measured, and tests
//! them against bounds.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::usage::BusyThread;
use crate::Quantiles;
use crate::circle::ms;

/// Minimum frame rate of the victim, as a share of its rate alone, if the other client draws nothing.
pub const MIN_FRAME_SHARE: f64 = 0.9;
/// Minimum frame rate of the victim, as a share of its rate alone, if the other client draws as much as it can.
pub const MIN_SHARED_FRAME_SHARE: f64 = 0.45;
/// Maximum of the longest gap between two frames, as a multiple of the 95th percentile of gaps without the other
/// client.
pub const MAX_GAP_RATIO: f64 = 4.0;
/// Maximum time of the victim's drags of features, as a multiple of their time without the other client.
pub const MAX_OWN_DRAG_RATIO: f64 = 2.0;
/// Maximum growth of the server's memory in MiB, after the other client has left and the rest period has passed.
pub const MAX_MEMORY_GROWTH_MIB: f64 = 250.0;
/// Maximum of the bytes written per edit if each edit has a new actor, as a multiple of those with one actor.
pub const MAX_WRITE_RATIO: f64 = 2.0;
/// Minimum share of its planned updates that the victim sends. With fewer the benchmark itself was too slow.
const MIN_UPDATE_SHARE: f64 = 0.75;

/// Events that a victim recorded.
#[derive(Clone, Debug, Default)]
pub(super) struct Timeline {
    /// Time at which each frame of the victim's view arrived, and the session's live revision that the frame shows.
    pub frames: Vec<(Instant, u32)>,
    /// Number of the victim's update that each live revision shows. Revisions with updates of other clients are left
    /// out.
    pub update_of: BTreeMap<u32, u64>,
    /// Time at which each of the victim's updates was sent.
    pub sent: Vec<Instant>,
    /// Drags of features by the victim, in the order in which they were sent.
    pub timed_drags: Vec<TimedDrag>,
    /// Reason that the victim's connections ended before it left. `None` if they did not.
    pub disconnect_reason: Option<String>,
}

/// Drag of a feature.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimedDrag {
    pub sent: Instant,
    pub answered: Option<Instant>,
}

/// Period of measurement.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeasuredWindow {
    pub from: Instant,
    pub to: Instant,
    /// Time up to which gaps and answers were followed that were still open at `to`.
    pub followed_to: Instant,
}

/// Frame rate, gaps and answer times of a victim.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct VictimPace {
    /// Number of frames per second that show a new update of the victim's drag.
    pub frames_per_second: f64,
    /// 95th percentile of the gaps between two such frames.
    pub p95_gap_ms: f64,
    /// Longest gap between two such frames. A gap may end after the period of measurement, but the part before it does
    /// not count.
    pub longest_gap_ms: f64,
    /// Number of updates per second that the victim sent.
    pub updates_per_second: f64,
    /// Number of drags of features that the victim sent or waited for.
    pub own_drags: usize,
    /// Time from sending a drag of a feature to its answer, or to the time at which the benchmark gave up waiting.
    pub own_drag_ms: Quantiles,
}

impl Timeline {
    /// Times of frames that show an update of the victim that no frame before had shown.
    fn new_frame_times(&self) -> Vec<Instant> {
        let mut latest = 0;
        let mut shown = Vec::new();
        for (came, revision) in &self.frames {
            let update = self.update_of.range(..=revision).next_back().map_or(0, |(_, update)| *update);
            if update > latest {
                latest = update;
                shown.push(*came);
            }
        }
        shown
    }

    pub fn pace(&self, window: MeasuredWindow) -> VictimPace {
        let MeasuredWindow { from, to, followed_to } = window;
        let is_within = |at: &Instant| (from..to).contains(at);
        let seconds = to.saturating_duration_since(from).as_secs_f64().max(f64::MIN_POSITIVE);
        let shown = self.new_frame_times();
        let gaps: Vec<f64> = gaps(&shown, window).into_iter().map(ms).collect();
        // A drag that was sent before the period and not answered by its start counts: one may be waited for all through.
        let drags_ms: Vec<f64> = (self.timed_drags.iter())
            .map(|drag| (drag.sent, drag.answered.unwrap_or(followed_to)))
            .filter(|(sent, answered)| *sent < to && *answered >= from)
            .map(|(sent, answered)| ms(answered.saturating_duration_since(sent)))
            .collect();
        let a_second = |times: &[Instant]| times.iter().filter(|at| is_within(at)).count() as f64 / seconds;
        VictimPace {
            frames_per_second: a_second(&shown),
            p95_gap_ms: Quantiles::of(gaps.iter().copied()).p95,
            longest_gap_ms: gaps.into_iter().fold(0.0, f64::max),
            updates_per_second: a_second(&self.sent),
            own_drags: drags_ms.len(),
            own_drag_ms: Quantiles::of(drags_ms),
        }
    }
}

/// Returns the gaps between frames that overlap the period of measurement, up to the first frame after it.
fn gaps(shown: &[Instant], window: MeasuredWindow) -> Vec<Duration> {
    let MeasuredWindow { from, to, followed_to } = window;
    let first = shown.partition_point(|at| *at < from);
    let last = shown.partition_point(|at| *at < to);
    // The part of a gap before the period does not count, so the first gap begins at the earliest at its start.
    let before = shown[..first].last().copied().map_or(from, |at| at.max(from));
    let behind = shown.get(last).copied().unwrap_or(followed_to).max(to);
    let ends = shown[first..last].iter().copied().chain([behind]);
    let starts = [before].into_iter().chain(shown[first..last].iter().copied());
    starts.zip(ends).map(|(from, to)| to.saturating_duration_since(from)).collect()
}

/// Bound that a row misses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum MissedBound {
    /// The victim's frame rate is too low.
    Share,
    /// A gap between two frames is too long.
    Gap,
    /// The victim's drags of features take too long.
    OwnDrag,
    /// The server keeps too much memory.
    Memory,
    /// Threads of the server use the CPU though no client needs them.
    BusyThreads,
    /// The server writes too much per edit.
    Writes,
    /// A connection of the victim ended.
    Connection,
    /// The victim did not send its updates: the benchmark itself was too slow, and the row is invalid.
    Updates,
    /// The other client did nothing, or all its requests were refused, or none was answered though some should be: the
    /// row is invalid.
    Other,
}

/// Measurements of a row that are compared with the bounds.
pub(super) struct JudgedRow<'a> {
    pub uses_renderer: bool,
    /// Pace of the victim without the other client.
    pub alone: VictimPace,
    /// Pace of the victim with the other client.
    pub with: VictimPace,
    pub grown_mib: f64,
    pub busy_threads: &'a [BusyThread],
    /// Bytes written per edit with many actors, as a multiple of those with one actor. `None` if the row does not
    /// measure this.
    pub writes: Option<f64>,
    pub is_connected: bool,
    pub is_other_idle: bool,
}

impl JudgedRow<'_> {
    /// Returns the victim's frame rate as a share of its rate without the other client.
    pub fn share(&self) -> f64 {
        ratio(self.with.frames_per_second, self.alone.frames_per_second)
    }

    pub fn gap(&self) -> f64 {
        ratio(self.with.longest_gap_ms, self.alone.p95_gap_ms)
    }

    /// Returns the median time of the victim's drags of features, as a multiple of their time without the other client.
    pub fn own_drag(&self) -> f64 {
        ratio(self.with.own_drag_ms.p50, self.alone.own_drag_ms.p50)
    }

    pub fn least_share(&self) -> f64 {
        if self.uses_renderer { MIN_SHARED_FRAME_SHARE } else { MIN_FRAME_SHARE }
    }

    pub fn missed(&self) -> Vec<MissedBound> {
        // A ratio that is not a number, like a share of no frames, misses its bound.
        let updates = ratio(self.with.updates_per_second, self.alone.updates_per_second);
        [
            (MissedBound::Share, self.share() >= self.least_share()),
            (MissedBound::Gap, self.gap() <= MAX_GAP_RATIO),
            (MissedBound::OwnDrag, self.with.own_drags > 0 && self.own_drag() <= MAX_OWN_DRAG_RATIO),
            (MissedBound::Memory, self.grown_mib <= MAX_MEMORY_GROWTH_MIB),
            (MissedBound::BusyThreads, self.busy_threads.is_empty()),
            (MissedBound::Writes, self.writes.is_none_or(|ratio| ratio <= MAX_WRITE_RATIO)),
            (MissedBound::Connection, self.is_connected),
            (MissedBound::Updates, updates >= MIN_UPDATE_SHARE),
            (MissedBound::Other, !self.is_other_idle),
        ]
        .into_iter()
        .filter_map(|(bound, holds)| (!holds).then_some(bound))
        .collect()
    }
}

/// Computes a ratio; NaN if `b` is not positive.
fn ratio(a: f64, b: f64) -> f64 {
    if b > 0.0 { a / b } else { f64::NAN }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Duration = Duration::from_millis(20);

    /// Simulates a victim that sends an update every 20 ms, during a period of measurement of two seconds and for a
    /// second before and after it. It sees each update 5 ms later. `change` gets the number of an update and returns
    /// the live revision of its frame, or `None` if the frame does not arrive.
    fn victim(change: impl Fn(u64) -> Option<u32>) -> (Timeline, MeasuredWindow) {
        let began = Instant::now();
        let at = |update: u64| began + FRAME * update as u32;
        let shown = |update: u64| change(update).map(|revision| (at(update) + FRAME / 4, revision));
        let ask = |n: u64| TimedDrag { sent: at(10 * n), answered: Some(at(10 * n) + FRAME) };
        let timeline = Timeline {
            frames: (1..200).filter_map(shown).collect(),
            update_of: (1..200).map(|update| (2 * update as u32, update)).collect(),
            sent: (1..200).map(at).collect(),
            timed_drags: (0..20).map(ask).collect(),
            disconnect_reason: None,
        };
        (timeline, MeasuredWindow { from: at(50), to: at(150), followed_to: at(160) })
    }

    /// Simulates a victim that sees each update in a frame of its own.
    #[expect(clippy::unnecessary_wraps, reason = "others leave frames out")]
    fn usual(update: u64) -> Option<u32> {
        Some(2 * update as u32)
    }

    fn pace(change: impl Fn(u64) -> Option<u32>) -> VictimPace {
        let (timeline, window) = victim(change);
        timeline.pace(window)
    }

    fn measured(with: VictimPace) -> JudgedRow<'static> {
        JudgedRow {
            uses_renderer: false,
            alone: pace(usual),
            with,
            grown_mib: 0.0,
            busy_threads: &[],
            writes: None,
            is_connected: true,
            is_other_idle: false,
        }
    }

    #[test]
    fn a_victim_that_loses_nothing_passes() {
        let usual = pace(usual);
        assert!((usual.frames_per_second - 50.0).abs() < 1e-9, "{usual:?}");
        assert!((usual.p95_gap_ms - 20.0).abs() < 1e-9 && (usual.longest_gap_ms - 20.0).abs() < 1e-9);
        assert_eq!((usual.own_drags, usual.own_drag_ms.p50), (10, 20.0));
        assert_eq!(measured(usual).missed(), []);
    }

    /// Deliberate faults that the judge must detect: frames arrive at the usual rate, but show another client's drag or
    /// updates that were shown before.
    #[test]
    fn frames_that_show_nothing_of_the_victims_drag_do_not_count() {
        let of_another = measured(pace(|_| Some(1)));
        assert_eq!((of_another.share(), of_another.missed()), (0.0, vec![MissedBound::Share, MissedBound::Gap]));
        let again = measured(pace(|update| usual(update - update % 4)));
        assert!((again.share() - 0.25).abs() < 0.02, "{}", again.share());
        assert!(again.missed().contains(&MissedBound::Share));
    }

    #[test]
    fn a_few_frames_less_pass_and_more_do_not() {
        let every = |n: u64| pace(move |update| usual(update).filter(|_| !update.is_multiple_of(n)));
        assert_eq!(measured(every(11)).missed(), []);
        assert_eq!(measured(every(8)).missed(), [MissedBound::Share]);
        let shared = JudgedRow { uses_renderer: true, ..measured(every(2)) };
        assert_eq!(shared.missed(), []);
        let every_third = pace(|update| usual(update).filter(|_| update.is_multiple_of(3)));
        let shared = JudgedRow { uses_renderer: true, ..measured(every_third) };
        assert_eq!(shared.missed(), [MissedBound::Share]);
    }

    /// Deliberate faults that the judge must detect: no frames arrive for a while, inside the measured period, at its
    /// end, or from before its start on.
    #[test]
    fn gaps_are_found_wherever_they_lie() {
        for (gap, ms) in [(100..103, 80.0), (100..104, 100.0), (147..152, 120.0), (40..54, 80.0)] {
            let with = pace(|update| usual(update).filter(|_| !gap.contains(&update)));
            assert!((with.longest_gap_ms - ms).abs() < 20.0 + 1e-9, "{gap:?}: {with:?}");
            let is_missed = measured(with).missed().contains(&MissedBound::Gap);
            assert_eq!(is_missed, with.longest_gap_ms > 80.0 + 1e-9, "{gap:?}: {with:?}");
        }
        let stopped = pace(|update| usual(update).filter(|_| update < 140));
        assert!(stopped.longest_gap_ms > 400.0, "it is followed past the end: {stopped:?}");
    }

    /// Deliberate faults that the judge must detect: the benchmark itself is too slow, answers take long or never come,
    /// and each other bound is missed alone.
    #[test]
    fn each_bound_is_missed_alone() {
        let (usual_timeline, window) = victim(usual);
        let with = |change: &dyn Fn(&mut Timeline)| {
            let mut timeline = usual_timeline.clone();
            change(&mut timeline);
            measured(timeline.pace(window)).missed()
        };
        assert_eq!(with(&|timeline| timeline.sent.truncate(100)), [MissedBound::Updates]);
        let late = |sent: Instant| Some(sent + 3 * FRAME);
        let never = |_: Instant| None;
        for answered in [late, never] {
            let answer = |timeline: &mut Timeline| {
                timeline.timed_drags.iter_mut().for_each(|drag| drag.answered = answered(drag.sent));
            };
            assert_eq!(with(&answer), [MissedBound::OwnDrag]);
        }
        assert_eq!(with(&|timeline| timeline.timed_drags.clear()), [MissedBound::OwnDrag]);
        let mut waited_throughout = usual_timeline.clone();
        waited_throughout.timed_drags.retain_mut(|drag| drag.sent < window.from && drag.answered.take().is_some());
        waited_throughout.timed_drags.drain(..4);
        let waited_throughout = waited_throughout.pace(window);
        assert_eq!((waited_throughout.own_drags, waited_throughout.own_drag_ms.p50), (1, 2400.0));

        let usual = pace(usual);
        let solves = [BusyThread { name: "solve".into(), share: 1.0 }];
        let all = [
            (JudgedRow { grown_mib: 251.0, ..measured(usual) }, MissedBound::Memory),
            (JudgedRow { busy_threads: &solves, ..measured(usual) }, MissedBound::BusyThreads),
            (JudgedRow { writes: Some(2.5), ..measured(usual) }, MissedBound::Writes),
            (JudgedRow { is_connected: false, ..measured(usual) }, MissedBound::Connection),
            (JudgedRow { is_other_idle: true, ..measured(usual) }, MissedBound::Other),
        ];
        for (measured, bound) in all {
            assert_eq!(measured.missed(), [bound]);
        }
    }
}

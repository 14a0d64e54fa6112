//! Costs of a frame's stages, each of which is waited for; `bendylights bench frame` shows them.

use std::ops::AddAssign;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// Part of the work on a frame whose time is measured by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameStage {
    /// Finds what pixels show: the G-buffer, or on the native backend the visibility buffer.
    Gbuffer,
    /// Fetches and interpolates attributes of what pixels show, on the native backend.
    Surfaces,
    /// Fits a bent map, and maps the casters' vertices into the tube.
    Vertices,
    /// Selects the mapped triangles that are straight in the map and in one slab.
    Triangles,
    /// Clips the other triangles to slabs.
    Clip,
    /// Splits clipped triangles until their edges are straight.
    Split,
    /// Draws a map. For a straight light, this includes the fit and, on the native backend, all of the map.
    Draw,
    /// Reads back a bent map's counts, to check if it fitted.
    Counts,
    Fill,
    /// Adds a light to the picture, or draws its layer: one run per light.
    Light,
    /// Sums layers, or such sums.
    Sum,
    /// Sums the fill and layers, exposes and tone-maps.
    Display,
    Readback,
}

impl FrameStage {
    /// All stages, in the order of a frame.
    pub const ALL: [Self; 13] = [
        Self::Gbuffer,
        Self::Surfaces,
        Self::Vertices,
        Self::Triangles,
        Self::Clip,
        Self::Split,
        Self::Draw,
        Self::Counts,
        Self::Fill,
        Self::Light,
        Self::Sum,
        Self::Display,
        Self::Readback,
    ];

    /// Returns the name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gbuffer => "gbuffer",
            Self::Surfaces => "surfaces",
            Self::Vertices => "vertices",
            Self::Triangles => "triangles",
            Self::Clip => "clip",
            Self::Split => "split",
            Self::Draw => "draw",
            Self::Counts => "counts",
            Self::Fill => "fill",
            Self::Light => "light",
            Self::Sum => "sum",
            Self::Display => "display",
            Self::Readback => "readback",
        }
    }
}

/// Wall time and CPU time of some work.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageCost {
    pub wall_ms: f64,
    /// CPU milliseconds of the whole process on all cores, including the threads of a software driver.
    pub cpu_ms: f64,
}

impl AddAssign for StageCost {
    fn add_assign(&mut self, other: Self) {
        self.wall_ms += other.wall_ms;
        self.cpu_ms += other.cpu_ms;
    }
}

/// Measures the times of consecutive laps.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    wall: Instant,
    cpu: Duration,
}

impl Stopwatch {
    /// Starts the first lap.
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: process_time() }
    }

    /// Ends the lap, returns its time, and starts the next.
    pub fn lap(&mut self) -> StageCost {
        let now = Self::start();
        let ms = |duration: Duration| duration.as_secs_f64() * 1000.0;
        let cost = StageCost { wall_ms: ms(now.wall - self.wall), cpu_ms: ms(now.cpu.saturating_sub(self.cpu)) };
        *self = now;
        cost
    }
}

/// Returns the CPU time of all threads of this process.
fn process_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
}

/// Amounts of work that a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorkCounters {
    /// Triangles processed for shadow maps, once per map; for an omni light or a very wide spotlight, once per face.
    pub triangles_seen: u64,
    /// Pairs of a triangle and a slab that were clipped, and split if necessary.
    pub triangles_split: u64,
    /// Triangles drawn into shadow maps.
    pub triangles_drawn: u64,
    pub texels: u64,
    /// Pixels of the rectangles in which lights were added, with background and pixels out of reach.
    pub scissor_pixels: u64,
    /// Bytes of the picture that were read back.
    pub bytes: u64,
}

/// Costs and amounts of work of a frame that was drawn stage by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recording {
    runs: [u64; FrameStage::ALL.len()],
    costs: [StageCost; FrameStage::ALL.len()],
    pub counters: WorkCounters,
}

impl Recording {
    /// Returns the number of runs of a stage.
    pub fn runs(&self, stage: FrameStage) -> u64 {
        self.runs[stage as usize]
    }

    /// Returns the total cost of a stage's runs. A run begins when the previous stage ends, so CPU work between two
    /// stages counts for the second.
    pub fn cost(&self, stage: FrameStage) -> StageCost {
        self.costs[stage as usize]
    }
}

/// Records the costs of frame stages on a device, separately for each thread that requests it.
#[derive(Debug, Default)]
pub(crate) struct StageRecorder(Mutex<Vec<ThreadRecording>>);

#[derive(Debug)]
struct ThreadRecording {
    thread: ThreadId,
    recording: Recording,
    watch: Stopwatch,
}

impl StageRecorder {
    pub fn start(&self) {
        let (thread, recording) = (thread::current().id(), Recording::default());
        self.lock().push(ThreadRecording { thread, recording, watch: Stopwatch::start() });
    }

    /// Stops recording the stages of this thread, and returns their costs.
    pub fn stop(&self) -> Recording {
        let (mut all, thread) = (self.lock(), thread::current().id());
        let own = all.iter().position(|running| running.thread == thread);
        own.map_or_else(Recording::default, |own| all.swap_remove(own).recording)
    }

    /// True if the costs of frame stages on this thread are recorded. Then each stage is submitted to the device by
    /// itself and waited for.
    pub fn is_recording(&self) -> bool {
        self.with_own(|_| ()).is_some()
    }

    /// Records the end of a stage, which has been waited for.
    pub fn record_stage(&self, stage: FrameStage) {
        self.with_own(|ThreadRecording { recording, watch, .. }| {
            recording.runs[stage as usize] += 1;
            recording.costs[stage as usize] += watch.lap();
        });
    }

    /// Adds to the frame's amounts of work, if this thread is recorded.
    pub fn count(&self, add: impl FnOnce(&mut WorkCounters)) {
        self.with_own(|running| add(&mut running.recording.counters));
    }

    fn with_own<T>(&self, work: impl FnOnce(&mut ThreadRecording) -> T) -> Option<T> {
        let thread = thread::current().id();
        self.lock().iter_mut().find(|running| running.thread == thread).map(work)
    }

    fn lock(&self) -> MutexGuard<'_, Vec<ThreadRecording>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Barrier;

    use super::*;

    #[test]
    fn threads_that_record_at_once_each_have_their_own() {
        let (recorder, together) = (StageRecorder::default(), Barrier::new(2));
        let record = |bytes: u64| {
            recorder.start();
            together.wait();
            for _ in 0..bytes {
                recorder.record_stage(FrameStage::Readback);
                recorder.count(|counters| counters.bytes += 1);
            }
            together.wait();
            let recording = recorder.stop();
            (recording.runs(FrameStage::Readback), recording.counters.bytes, recorder.is_recording())
        };
        let [three, five] = thread::scope(|scope| {
            [3, 5].map(|bytes| scope.spawn(move || record(bytes))).map(|thread| thread.join().expect("recorded"))
        });
        assert_eq!((three, five), ((3, 3, false), (5, 5, false)));
        // No thread records.
        recorder.record_stage(FrameStage::Readback);
        assert_eq!(recorder.stop(), Recording::default());
    }
}

//! What a frame's stages cost, each waited for: what `bendylights bench frame` shows.

use std::ops::AddAssign;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, ThreadId};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

/// A part of a frame that is encoded, or waited for, by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameStage {
    /// What each pixel sees.
    Gbuffer,
    /// That read back, and made ready to be lit by the processor where it draws.
    Surfaces,
    /// The vertices of what casts shadows, mapped into a bent light's tube; with the fitting of its map.
    Vertices,
    /// Those of its triangles sorted out that are straight in the map and lie in one slab.
    Triangles,
    /// The others, cut where one slab ends and the next begins.
    Clip,
    /// Those split until their edges are straight.
    Split,
    /// A map drawn; of a straight light with the fitting of its map, and all of one that the processor draws.
    Draw,
    /// How much came of a bent map's stages, read back to see whether there was room.
    Counts,
    /// What of the picture comes from no light.
    Fill,
    /// A light added to the picture, or a layer of what it alone adds: one run a light.
    Light,
    /// Layers of some lights, or sums of those, added up.
    Sum,
    /// The fill and what lights add, weighed, exposed and tone-mapped.
    Display,
    /// The picture's bytes, read back.
    Readback,
}

impl FrameStage {
    /// Every stage, in the order of a frame.
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

    /// What it is called in reports.
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

/// What some work took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageCost {
    /// Milliseconds that passed.
    pub wall_ms: f64,
    /// Milliseconds of the whole process on all cores: with a driver that draws on the processor, its threads too.
    pub cpu_ms: f64,
}

impl AddAssign for StageCost {
    fn add_assign(&mut self, other: Self) {
        self.wall_ms += other.wall_ms;
        self.cpu_ms += other.cpu_ms;
    }
}

/// Measures laps.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch {
    wall: Instant,
    cpu: Duration,
}

impl Stopwatch {
    /// The first lap begins.
    pub fn start() -> Self {
        Self { wall: Instant::now(), cpu: process_time() }
    }

    /// What the lap took that ends here; the next begins.
    pub fn lap(&mut self) -> StageCost {
        let now = Self::start();
        let ms = |duration: Duration| duration.as_secs_f64() * 1000.0;
        let cost =
            StageCost { wall_ms: ms(now.wall - self.wall), cpu_ms: ms(now.cpu.saturating_sub(self.cpu)) };
        *self = now;
        cost
    }
}

/// What all threads of this process have run for.
fn process_time() -> Duration {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec as u32)
}

/// How much was worked on in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WorkCounters {
    /// Triangles that were looked at for shadow maps, once a map; of an omni light's or a very wide spotlight's, once a face.
    pub triangles_seen: u64,
    /// Pairs of a triangle and a slab of a tube that were clipped, and split where that was not enough.
    pub triangles_split: u64,
    /// Triangles that were handed to the rasteriser for shadow maps.
    pub triangles_drawn: u64,
    /// Texels of the maps that were drawn.
    pub texels: u64,
    /// Pixels of the rectangles that lights were added in, background and what lies beside the light in them too.
    pub scissor_pixels: u64,
    /// Bytes of the picture that were read back.
    pub bytes: u64,
}

/// A frame that was drawn stage by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Recording {
    runs: [u64; FrameStage::ALL.len()],
    costs: [StageCost; FrameStage::ALL.len()],
    /// How much was worked on.
    pub counters: WorkCounters,
}

impl Recording {
    /// How often a stage ran.
    pub fn runs(&self, stage: FrameStage) -> u64 {
        self.runs[stage as usize]
    }

    /// What all its runs took together. One begins where the stage before has ended, so that what the processor does
    /// between two stages counts to the second.
    pub fn cost(&self, stage: FrameStage) -> StageCost {
        self.costs[stage as usize]
    }
}

/// Takes down the stages of what threads draw on a device, of each that asked for it by itself.
#[derive(Debug, Default)]
pub(crate) struct StageRecorder(Mutex<Vec<ThreadRecording>>);

/// A recording that goes on.
#[derive(Debug)]
struct ThreadRecording {
    thread: ThreadId,
    recording: Recording,
    watch: Stopwatch,
}

impl StageRecorder {
    /// On from here, for this thread.
    pub fn start(&self) {
        let (thread, recording) = (thread::current().id(), Recording::default());
        self.lock().push(ThreadRecording { thread, recording, watch: Stopwatch::start() });
    }

    /// Off from here; what was taken down.
    pub fn stop(&self) -> Recording {
        let (mut all, thread) = (self.lock(), thread::current().id());
        let own = all.iter().position(|running| running.thread == thread);
        own.map_or_else(Recording::default, |own| all.swap_remove(own).recording)
    }

    /// Whether stages of this thread are taken down, and so submitted one by one.
    pub fn is_recording(&self) -> bool {
        self.with_own(|_| ()).is_some()
    }

    /// Takes down that a stage has ended, which was waited for.
    pub fn record_stage(&self, stage: FrameStage) {
        self.with_own(|ThreadRecording { recording, watch, .. }| {
            recording.runs[stage as usize] += 1;
            recording.costs[stage as usize] += watch.lap();
        });
    }

    /// Counts what a stage has worked on.
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
            [3, 5]
                .map(|bytes| scope.spawn(move || record(bytes)))
                .map(|thread| thread.join().expect("recorded"))
        });
        assert_eq!((three, five), ((3, 3, false), (5, 5, false)));
        // Nobody records.
        recorder.record_stage(FrameStage::Readback);
        assert_eq!(recorder.stop(), Recording::default());
    }
}

//! Process's side of a device: memory, yields and the times of stages.

use relight::YieldPolicy;

use super::memory::MemoryBudget;
use super::stages::StageRecorder;
use crate::RenderError;

/// Memory budget and yields of a device. All its renderers share them.
#[derive(Debug, Default)]
pub struct Host {
    pub(crate) memory: MemoryBudget,
    pub(crate) yielding: YieldPolicy,
    pub(crate) stages: StageRecorder,
}

impl Host {
    /// Makes a host whose cached data counts against `memory`.
    pub fn new(memory: MemoryBudget) -> Self {
        Self { memory, ..Self::default() }
    }

    /// Returns the host with a policy by which long work yields. Meanwhile other threads must not draw with the same
    /// [`crate::Renderer`]. A picture that is cancelled at a yield returns [`RenderError::Cancelled`].
    #[must_use]
    pub fn with_yield_policy(self, yielding: YieldPolicy) -> Self {
        Self { yielding, ..self }
    }

    pub(crate) fn yield_point(&self) -> Result<(), RenderError> {
        Ok(self.yielding.yield_point()?)
    }

    /// Runs long CPU work while other workers draw.
    pub(crate) fn run_in_background<T: Send>(&self, work: impl FnOnce() -> T + Send) -> Result<T, RenderError> {
        Ok(self.yielding.run_in_background(work)?)
    }
}

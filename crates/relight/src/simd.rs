//! Selection at run time among code compiled for several kinds of processors.

use pulp::{Arch, Simd, WithSimd};

/// Task for vectors of sixteen lanes. `run` and everything that it calls must be inlined. Closures are not inlined
/// reliably.
pub(crate) trait SimdTask {
    type Output;
    /// Runs the task. It must be `#[inline(always)]`, or it is compiled for the oldest processor.
    fn run(self) -> Self::Output;
}

struct PulpAdapter<W>(W);

impl<W: SimdTask> WithSimd for PulpAdapter<W> {
    type Output = W::Output;
    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> W::Output {
        self.0.run()
    }
}

/// Runs `work` with the widest vectors of the present processor.
#[inline]
pub(crate) fn run<W: SimdTask>(work: W) -> W::Output {
    Arch::new().dispatch(PulpAdapter(work))
}

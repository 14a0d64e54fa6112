//! Code compiled for several kinds of processors, chosen when it runs.

use pulp::{Arch, Simd, WithSimd};

/// Work on sixteen lanes: `run` and all it calls has to be inlined, and closures are not.
pub(crate) trait SimdTask {
    /// What comes of it.
    type Output;
    /// Does it. `#[inline(always)]`, or it is compiled for the oldest processor.
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

/// Does `work` with the widest vectors that this processor has.
#[inline]
pub(crate) fn run<W: SimdTask>(work: W) -> W::Output {
    Arch::new().dispatch(PulpAdapter(work))
}

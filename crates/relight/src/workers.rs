//! The threads that relight: one a core, and no more, whoever asks.

use rayon::{ThreadPool, ThreadPoolBuilder};

/// A pool of threads. Whoever gives it work waits until it is done.
#[derive(Debug)]
pub struct Workers(ThreadPool);

impl Workers {
    /// One a core.
    pub fn new() -> Self {
        Self::of(0)
    }

    /// So many; 0 for one a core.
    pub fn of(count: usize) -> Self {
        let name = |index| format!("relight {index}");
        let pool = ThreadPoolBuilder::new().num_threads(count).thread_name(name).build();
        Self(pool.expect("a program that cannot start threads cannot draw"))
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.0.current_num_threads()
    }

    /// Runs `work` in the pool, where rayon's iterators use its threads.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        self.0.install(work)
    }
}

impl Default for Workers {
    fn default() -> Self {
        Self::new()
    }
}

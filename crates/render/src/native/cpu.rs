//! The CPU as a device.

use std::sync::OnceLock;
use std::thread;

use relight::Workers;

use crate::Host;

/// The CPU, with threads that all renderers share.
#[derive(Debug)]
pub struct Cpu {
    pub(crate) host: Host,
    /// Started when the first picture is drawn.
    workers: OnceLock<Workers>,
}

impl Cpu {
    /// Makes a device of all cores.
    pub fn new(host: Host) -> Self {
        Self { host, workers: OnceLock::new() }
    }

    pub(crate) fn workers(&self) -> &Workers {
        self.workers.get_or_init(|| Workers::with_threads(0).with_yield_policy(self.host.yielding.clone()))
    }

    /// Returns a name for reports: the number of threads.
    pub(crate) fn name() -> String {
        format!("CPU, {} threads", thread::available_parallelism().map_or(1, usize::from))
    }
}

//! What every part of the server uses.

use std::sync::Arc;
use std::time::Instant;

use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::in_flight::InFlight;
use crate::metrics::Metrics;
use crate::renderer::Renders;
use crate::scenes::Scenes;
use crate::storage::Storage;
use crate::trace::Trace;

/// One of each; clones share them.
#[derive(Clone, Debug)]
pub struct Backend {
    /// Logs and assets.
    pub storage: Storage,
    /// Decoded scenes.
    pub scenes: Arc<Scenes>,
    /// The renderer.
    pub renders: Renders,
    /// A permit for each probe whose rays are followed.
    pub probes: Arc<Semaphore>,
    /// A permit for each drag that is solved beside its session.
    pub solves: Arc<Semaphore>,
    /// Bytes of bodies, answers and messages.
    pub in_flight: InFlight,
    /// What is counted.
    pub metrics: Arc<Metrics>,
    /// What is told of each picture.
    pub trace: Trace,
    /// Cancelled when the server is asked to stop.
    pub draining: CancellationToken,
    /// When the server started: the zero of its clock.
    pub started: Instant,
    /// The tasks of sockets, which a stopping server waits for.
    pub sockets: TaskTracker,
}

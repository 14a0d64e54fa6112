//! What every part of the server uses.

use std::sync::Arc;
use std::time::Instant;

use tokio::sync::Semaphore;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::in_flight::ByteBudget;
use crate::metrics::Metrics;
use crate::pacing::RequestPacing;
use crate::renderer::RenderQueue;
use crate::scenes::SceneCache;
use crate::solver::Solver;
use crate::storage::Storage;
use crate::trace::Trace;
use crate::views::MovingPixels;

/// One of each; clones share them.
#[derive(Clone, Debug)]
pub struct Services {
    /// Logs and assets.
    pub storage: Storage,
    /// Decoded scenes.
    pub scenes: Arc<SceneCache>,
    /// The renderer.
    pub renders: RenderQueue,
    /// What of views moves, by actor.
    pub moving_pixels: Arc<MovingPixels>,
    /// A permit for each probe whose rays are followed.
    pub probes: Arc<Semaphore>,
    /// Threads that solve drags.
    pub solver: Solver,
    /// Holds back edits.
    pub edit_pacing: Arc<RequestPacing>,
    /// Holds back requests.
    pub request_pacing: Arc<RequestPacing>,
    /// Bytes of bodies, answers and messages.
    pub in_flight: ByteBudget,
    /// What is counted.
    pub metrics: Arc<Metrics>,
    /// What is told of each picture.
    pub trace: Trace,
    /// Cancelled when the server is asked to stop.
    pub draining: CancellationToken,
    /// Names this run of the server among all there ever were.
    pub run: Arc<str>,
    /// When the server started: the zero of its clock.
    pub started: Instant,
    /// The tasks of sockets, which a stopping server waits for.
    pub sockets: TaskTracker,
}

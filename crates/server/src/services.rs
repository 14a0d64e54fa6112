//! Services that every part of the server uses.

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

/// The services that all sessions and requests share. Clones share them.
#[derive(Clone, Debug)]
pub struct Services {
    pub storage: Storage,
    pub scenes: Arc<SceneCache>,
    pub renders: RenderQueue,
    /// Pixels of moving views, by actor.
    pub moving_pixels: Arc<MovingPixels>,
    /// A permit for each probe that traces rays.
    pub probes: Arc<Semaphore>,
    pub solver: Solver,
    /// Throttles edits.
    pub edit_pacing: Arc<RequestPacing>,
    /// Throttles requests.
    pub request_pacing: Arc<RequestPacing>,
    /// Counts the bytes of bodies, answers and messages in memory.
    pub in_flight: ByteBudget,
    pub metrics: Arc<Metrics>,
    /// Trace of pictures.
    pub trace: Trace,
    /// Cancelled when the server is asked to stop.
    pub draining: CancellationToken,
    /// Identifies this run of the server among all others.
    pub run: Arc<str>,
    /// Start of the server: the zero of its clock.
    pub started: Instant,
    /// Tasks of sockets, for which a stopping server waits.
    pub sockets: TaskTracker,
}

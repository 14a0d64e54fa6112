//! Permits for anonymous requests: those of connections that have not shown the token. Their number at once is limited
//! in total, and the others wait.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::sleep;

use crate::limits::{ANONYMOUS_BYTES_PER_SECOND, MAX_ANONYMOUS_REQUESTS, MIN_ANONYMOUS_PERMIT_TIME};

/// Permits for anonymous requests that are answered at once.
pub struct AnonymousPermits(Arc<Semaphore>);

impl AnonymousPermits {
    pub fn new() -> Self {
        Self(Arc::new(Semaphore::new(MAX_ANONYMOUS_REQUESTS)))
    }

    /// Waits for a permit. Dropping the future takes none.
    pub async fn acquire(&self) -> AnonymousPermit {
        AnonymousPermit(Arc::clone(&self.0).acquire_owned().await.expect("never closed"))
    }
}

/// A permit. It is released at once if it is dropped without [`Self::release_after_bytes`].
pub struct AnonymousPermit(OwnedSemaphorePermit);

impl AnonymousPermit {
    /// Releases the permit after the time that an answer of that size counts for.
    pub fn release_after_bytes(self, bytes: u64) {
        let for_bytes = Duration::from_secs_f64(bytes as f64 / ANONYMOUS_BYTES_PER_SECOND as f64);
        tokio::spawn(async move {
            sleep(MIN_ANONYMOUS_PERMIT_TIME.max(for_bytes)).await;
            drop(self.0);
        });
    }
}

#[cfg(test)]
mod tests {
    use tokio::time::Instant;

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn anonymous_requests_and_bytes_are_limited_together() {
        let permits = AnonymousPermits::new();
        let time_of = async |count: usize, bytes| {
            let before = Instant::now();
            for _ in 0..count {
                permits.acquire().await.release_after_bytes(bytes);
            }
            before.elapsed()
        };
        assert_eq!(time_of(MAX_ANONYMOUS_REQUESTS, 0).await, Duration::ZERO, "one page is loaded at once");
        let rounds = 10;
        let waited = time_of(rounds * MAX_ANONYMOUS_REQUESTS, 0).await;
        assert!(waited >= MIN_ANONYMOUS_PERMIT_TIME * rounds as u32, "{waited:?}");
        time_of(MAX_ANONYMOUS_REQUESTS, 2 * ANONYMOUS_BYTES_PER_SECOND).await;
        let waited = time_of(1, 0).await;
        assert!(waited >= Duration::from_secs(2), "{waited:?}: large answers count for longer");
    }

    #[tokio::test(start_paused = true)]
    async fn a_request_that_stops_waiting_takes_no_permit() {
        let permits = AnonymousPermits::new();
        for _ in 0..MAX_ANONYMOUS_REQUESTS {
            permits.acquire().await.release_after_bytes(0);
        }
        for _ in 0..1_000 {
            assert!(tokio::time::timeout(Duration::ZERO, permits.acquire()).await.is_err());
        }
        let began = Instant::now();
        permits.acquire().await;
        assert!(began.elapsed() <= 2 * MIN_ANONYMOUS_PERMIT_TIME, "{:?}", began.elapsed());
    }
}

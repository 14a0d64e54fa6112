//! Permits for anonymous requests: those of connections that have not shown the token. Their number at once is limited
//! in total, and the others wait.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::sleep;

use crate::limits::{ANONYMOUS_BYTES_PER_SECOND, MAX_ANONYMOUS_REQUESTS, MIN_ANONYMOUS_PERMIT_TIME};

/// Permits for anonymous requests that are answered at once.
pub struct AnonymousPermits(Arc<Semaphore>);

impl Default for AnonymousPermits {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(MAX_ANONYMOUS_REQUESTS)))
    }
}

impl AnonymousPermits {
    /// Waits for a permit. Dropping the future takes none.
    pub async fn acquire(&self) -> AnonymousPermit {
        AnonymousPermit { _permit: Arc::clone(&self.0).acquire_owned().await.expect("never closed") }
    }
}

/// A permit. It is released at once if it is dropped without [`Self::release_after_bytes`].
pub struct AnonymousPermit {
    _permit: OwnedSemaphorePermit,
}

impl AnonymousPermit {
    /// Releases the permit after the time that an answer of that size counts for.
    pub fn release_after_bytes(self, bytes: u64) {
        let for_bytes = Duration::from_secs_f64(bytes as f64 / ANONYMOUS_BYTES_PER_SECOND as f64);
        tokio::spawn(async move {
            sleep(MIN_ANONYMOUS_PERMIT_TIME.max(for_bytes)).await;
            drop(self);
        });
    }
}

#[cfg(test)]
mod tests {
    use tokio::time::Instant;

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn anonymous_requests_and_bytes_are_limited_together() {
        let turns = AnonymousPermits::default();
        let asked = async |count: usize, bytes| {
            let before = Instant::now();
            for _ in 0..count {
                turns.acquire().await.release_after_bytes(bytes);
            }
            before.elapsed()
        };
        assert_eq!(asked(MAX_ANONYMOUS_REQUESTS, 0).await, Duration::ZERO, "one page is loaded at once");
        let rounds = 10;
        let waited = asked(rounds * MAX_ANONYMOUS_REQUESTS, 0).await;
        assert!(waited >= MIN_ANONYMOUS_PERMIT_TIME * rounds as u32, "{waited:?}");
        asked(MAX_ANONYMOUS_REQUESTS, 2 * ANONYMOUS_BYTES_PER_SECOND).await;
        let waited = asked(1, 0).await;
        assert!(waited >= Duration::from_secs(2), "{waited:?}: large answers count for longer");
    }

    #[tokio::test(start_paused = true)]
    async fn who_gives_up_waiting_takes_no_turn() {
        let turns = AnonymousPermits::default();
        for _ in 0..MAX_ANONYMOUS_REQUESTS {
            turns.acquire().await.release_after_bytes(0);
        }
        for _ in 0..1_000 {
            assert!(tokio::time::timeout(Duration::ZERO, turns.acquire()).await.is_err());
        }
        let began = Instant::now();
        turns.acquire().await;
        assert!(began.elapsed() <= 2 * MIN_ANONYMOUS_PERMIT_TIME, "{:?}", began.elapsed());
    }
}

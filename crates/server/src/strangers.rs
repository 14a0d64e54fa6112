//! Turns of strangers: requests of connections that have not shown the token. However many there are, what they ask for
//! together is bounded; the others wait.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::sleep;

use crate::limits::{MAX_STRANGER_REQUESTS, STRANGER_BYTES_PER_SECOND, STRANGER_TURN};

/// Requests of strangers that are answered at once.
pub struct Turns(Arc<Semaphore>);

impl Default for Turns {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(MAX_STRANGER_REQUESTS)))
    }
}

impl Turns {
    /// Waits for a turn. Whoever gives up meanwhile has taken none.
    pub async fn next(&self) -> Turn {
        Turn { _permit: Arc::clone(&self.0).acquire_owned().await.expect("never closed") }
    }
}

/// One of them. Dropped without [`Self::end`] it is over at once.
pub struct Turn {
    _permit: OwnedSemaphorePermit,
}

impl Turn {
    /// Ends the turn after the time that an answer of so many bytes counts for.
    pub fn end(self, bytes: u64) {
        let for_bytes = Duration::from_secs_f64(bytes as f64 / STRANGER_BYTES_PER_SECOND as f64);
        tokio::spawn(async move {
            sleep(STRANGER_TURN.max(for_bytes)).await;
            drop(self);
        });
    }
}

#[cfg(test)]
mod tests {
    use tokio::time::Instant;

    use super::*;

    #[tokio::test(start_paused = true)]
    async fn strangers_together_get_so_many_requests_and_bytes() {
        let turns = Turns::default();
        let asked = async |count: usize, bytes| {
            let before = Instant::now();
            for _ in 0..count {
                turns.next().await.end(bytes);
            }
            before.elapsed()
        };
        assert_eq!(asked(MAX_STRANGER_REQUESTS, 0).await, Duration::ZERO, "one page is loaded at once");
        let rounds = 10;
        let waited = asked(rounds * MAX_STRANGER_REQUESTS, 0).await;
        assert!(waited >= STRANGER_TURN * rounds as u32, "{waited:?}");
        asked(MAX_STRANGER_REQUESTS, 2 * STRANGER_BYTES_PER_SECOND).await;
        let waited = asked(1, 0).await;
        assert!(waited >= Duration::from_secs(2), "{waited:?}: large answers count for longer");
    }

    #[tokio::test(start_paused = true)]
    async fn who_gives_up_waiting_takes_no_turn() {
        let turns = Turns::default();
        for _ in 0..MAX_STRANGER_REQUESTS {
            turns.next().await.end(0);
        }
        for _ in 0..1_000 {
            assert!(tokio::time::timeout(Duration::ZERO, turns.next()).await.is_err());
        }
        let began = Instant::now();
        turns.next().await;
        assert!(began.elapsed() <= 2 * STRANGER_TURN, "{:?}", began.elapsed());
    }
}

//! Throttling of clients that send much while a user of another client moves a view. Their messages are read later, and
//! nothing is refused.

use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use tokio::sync::{OwnedMutexGuard, OwnedSemaphorePermit, Semaphore};
use tokio::time::sleep_until;

use crate::ServerError;
use crate::allowances::{Allowance, AllowanceRate, Allowances};
use crate::background;
use crate::charges::Payer;
use crate::limits::{MAX_UPLOAD_CHARGE, MESSAGE_COST_EDITS, MOVING_FOR, THROTTLED_MESSAGE_RATE, THROTTLED_UPLOAD_RATE};
use crate::views::MovingPixels;

/// Throttle of a socket's messages. Edits also count for the client.
#[derive(Debug)]
pub struct SocketPacing {
    payer: Payer,
    allowance: Allowance,
    edits: Arc<RequestPacing>,
}

/// Throttle that all clients share, for edits or for requests.
#[derive(Debug)]
pub struct RequestPacing {
    allowances: Mutex<Allowances>,
    moving: Arc<MovingPixels>,
}

/// Throttle that all clients share, for the decoding of uploads. Uploads wait here for each other. So the decoder stays
/// free to open a scene while an upload waits.
#[derive(Debug)]
pub struct UploadPacing {
    allowance: Allowance,
    moving: Arc<MovingPixels>,
}

impl SocketPacing {
    /// Makes the throttle of a socket of that client. It shares `edits` with requests and other sockets.
    pub fn new(payer: Payer, edits: &Arc<RequestPacing>) -> Self {
        let allowance = Allowance::full(THROTTLED_MESSAGE_RATE, Instant::now());
        Self { payer, allowance, edits: Arc::clone(edits) }
    }

    /// Waits until the next message may be carried out.
    pub async fn wait(&mut self) {
        let try_take = |now| self.allowance.try_take(1.0, now);
        wait_while_others_interact(&self.edits.moving, self.payer.actor_id(), try_take).await;
    }

    /// Waits until the next edit may be carried out.
    pub async fn wait_to_edit(&self) {
        self.edits.wait(&self.payer, 1.0 + MESSAGE_COST_EDITS).await;
    }
}

impl RequestPacing {
    /// Makes a throttle that lets a client do as much as `rate` allows while another client is interactive.
    pub fn new(rate: AllowanceRate, moving: Arc<MovingPixels>) -> Self {
        Self { allowances: Mutex::new(Allowances::new(rate)), moving }
    }

    /// Waits until the client's next request may be carried out. The request takes `count` tokens.
    pub async fn wait(&self, payer: &Payer, count: f64) {
        let try_take = |now| {
            let mut allowances = self.allowances.lock().unwrap_or_else(PoisonError::into_inner);
            allowances.try_take(payer, count, now)
        };
        wait_while_others_interact(&self.moving, payer.actor_id(), try_take).await;
    }
}

impl UploadPacing {
    pub fn new(moving: Arc<MovingPixels>) -> Self {
        Self { allowance: Allowance::full(THROTTLED_UPLOAD_RATE, Instant::now()), moving }
    }

    /// Runs `decode` in the background, once an upload may be decoded and nothing else is. Returns its result with the
    /// permit of `decoding`.
    pub async fn run<T: Send + 'static>(
        mut turn: OwnedMutexGuard<Self>,
        decoding: &Arc<Semaphore>,
        decode: impl FnOnce() -> T + Send + 'static,
    ) -> Result<(T, OwnedSemaphorePermit), ServerError> {
        let moving = Arc::clone(&turn.moving);
        wait_while_others_interact(&moving, None, |now| turn.allowance.try_take(0.0, now)).await;
        let permit = Arc::clone(decoding).acquire_owned().await.map_err(|_| ServerError::Internal)?;
        let timed = move || {
            let start = Instant::now();
            let decoded = decode();
            let now = Instant::now();
            // The upload is charged even if nobody waits for it any more, since `turn` moves into the thread.
            turn.allowance.take((now - start).min(MAX_UPLOAD_CHARGE).as_secs_f64(), now);
            decoded
        };
        background::run_with(permit, timed).await
    }
}

/// Waits until no other client is interactive, or until `try_take` succeeds. `try_take` takes an amount or returns the
/// time at which it can.
async fn wait_while_others_interact(
    moving: &MovingPixels,
    actor_id: Option<&Arc<str>>,
    mut try_take: impl FnMut(Instant) -> Result<(), Instant>,
) {
    loop {
        let now = Instant::now();
        if !moving.is_another_interacting(actor_id, now) {
            return;
        }
        let Err(back_at) = try_take(now) else { return };
        // The other client may be at rest by then.
        sleep_until(back_at.min(now + MOVING_FOR).into()).await;
    }
}

#[cfg(test)]
mod tests {
    use std::thread::sleep;
    use std::time::Duration;

    use render::ViewSlot;
    use tokio::sync::Mutex;
    use tokio::time::timeout;

    use super::*;
    use crate::charges::tests::payer;
    use crate::limits::THROTTLED_EDIT_RATE;

    fn moved_by(actor_id: &str) -> Arc<MovingPixels> {
        let moving = Arc::<MovingPixels>::default();
        move_view(&moving, actor_id);
        moving
    }

    fn move_view(moving: &MovingPixels, actor_id: &str) {
        moving.record_picture(&actor_id.into(), ViewSlot(1), true, [640, 360], Instant::now());
    }

    fn pacing_of(actor: &str, moving: Arc<MovingPixels>) -> SocketPacing {
        let edits = Arc::new(RequestPacing::new(THROTTLED_EDIT_RATE, moving));
        SocketPacing::new(payer("shot", actor), &edits)
    }

    /// Measures the seconds in which one client's socket lets through `more` messages beyond the burst.
    async fn seconds_of_messages(moving: Arc<MovingPixels>, more: f64) -> f64 {
        let (mut pacing, start) = (pacing_of("ben", moving), Instant::now());
        for _ in 0..(THROTTLED_MESSAGE_RATE.burst + more) as usize {
            pacing.wait().await;
        }
        start.elapsed().as_secs_f64()
    }

    #[tokio::test]
    async fn messages_wait_while_another_client_interacts() {
        let more = 100.0;
        // The message before the first one that waits is let through, though less than one token is left.
        let least = (more - 2.0) / THROTTLED_MESSAGE_RATE.per_second;
        let beside_another = seconds_of_messages(moved_by("ada"), more).await;
        assert!(beside_another > least, "{beside_another} s");
        let (mut own, now) = (pacing_of("ada", moved_by("ada")), Instant::now());
        own.allowance.try_take(THROTTLED_MESSAGE_RATE.burst + 1.0, now).expect("all is left");
        let before = own.allowance.try_take(1.0, now);
        own.wait().await;
        assert_eq!((own.allowance.try_take(1.0, now), before.is_err()), (before, true), "nothing is taken");
    }

    #[tokio::test]
    async fn edits_wait_for_those_of_their_session_whoever_makes_them() {
        let pacing = RequestPacing::new(THROTTLED_EDIT_RATE, moved_by("ada"));
        // A view counts as moving for 300 ms after its last picture, and this amount refills in less.
        let more = 30.0;
        pacing.wait(&payer("shot", "ben"), THROTTLED_EDIT_RATE.burst + more).await;
        let start = Instant::now();
        pacing.wait(&payer("elsewhere", "eve"), 1.0).await;
        pacing.wait(&payer("shot", "ada"), 1.0).await;
        let of_others = start.elapsed();
        // Other actors of the session share its allowance. Deliberate fault that the check must detect: an allowance
        // for each name.
        pacing.wait(&payer("shot", "eve"), 1.0).await;
        let least = Duration::from_secs_f64(more / THROTTLED_EDIT_RATE.per_second);
        assert!(of_others < least / 2 && start.elapsed() > least / 2, "{of_others:?}");
    }

    #[tokio::test]
    async fn uploads_that_wait_keep_nobody_from_decoding() {
        let (decoding, moving) = (Arc::new(Semaphore::new(1)), moved_by("ada"));
        let uploads = Arc::new(Mutex::new(UploadPacing::new(moving)));
        let mut turn = Arc::clone(&uploads).lock_owned().await;
        turn.allowance.take(THROTTLED_UPLOAD_RATE.burst + 1.0, Instant::now());
        let waits = UploadPacing::run(turn, &decoding, || ());
        assert!(timeout(Duration::from_millis(20), waits).await.is_err());
        assert!(decoding.try_acquire().is_ok());
    }

    #[tokio::test]
    async fn uploads_rest_only_while_a_client_interacts() {
        let work = Duration::from_millis(5);
        let seconds = async |view_moves: bool| {
            let moving = Arc::<MovingPixels>::default();
            let decoding = Arc::new(Semaphore::new(1));
            let uploads = Arc::new(Mutex::new(UploadPacing::new(Arc::clone(&moving))));
            let turn = || Arc::clone(&uploads).lock_owned();
            let start = Instant::now();
            turn().await.allowance.try_take(THROTTLED_UPLOAD_RATE.burst, start).expect("all is left");
            for _ in 0..10 {
                if view_moves {
                    move_view(&moving, "ada");
                }
                drop(UploadPacing::run(turn().await, &decoding, move || sleep(work)).await.expect("decoded"));
            }
            start.elapsed().as_secs_f64()
        };
        let beside = seconds(true).await;
        // The least of three: other processes can only add to it.
        let alone = seconds(false).await.min(seconds(false).await).min(seconds(false).await);
        // Each upload waits for the amount that the one before took. Deliberate fault that the check must detect: no
        // allowance is taken.
        let work = work.as_secs_f64();
        let rests = 9.0 * work * (1.0 / THROTTLED_UPLOAD_RATE.per_second - 1.0);
        assert!(beside >= 10.0 * work + rests && alone < beside, "{beside} s, {alone} s alone");
    }
}

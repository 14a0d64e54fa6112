//! Budget for bytes in flight: request bodies until they are answered, and large answers and messages until the client
//! has taken them. All clients share one budget, so the server's memory does not grow with their number. Bodies get
//! half of it, so a client that sends as many bodies as fit does not prevent answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::body::Bytes;

use crate::ServerError;
use crate::limits::{
    MAX_BODY_BYTES_IN_FLIGHT, MAX_BYTES_IN_FLIGHT, MIN_DELIVERY_BYTES_PER_SECOND, SEND_TIMEOUT,
};

/// Counts bytes in flight against `MAX_BYTES_IN_FLIGHT`. Clones share the count.
#[derive(Clone, Debug, Default)]
pub struct ByteBudget(Arc<BudgetCounters>);

#[derive(Debug, Default)]
struct BudgetCounters {
    bytes: AtomicUsize,
    /// Part of `bytes` that is reserved for bodies.
    body_bytes: AtomicUsize,
}

/// Reserved bytes of the budget. Dropping the reservation frees them.
#[derive(Debug)]
pub struct ByteReservation {
    account: ByteBudget,
    bytes: usize,
}

/// Reserved bytes of the budget for a body. Dropping the reservation frees them.
#[derive(Debug)]
pub struct BodyReservation(ByteReservation);

impl ByteBudget {
    /// Reserves bytes, or gives an error if they do not fit. Any number of bytes fits if none are reserved.
    pub fn reserve(&self, bytes: usize) -> Result<ByteReservation, ServerError> {
        try_add(&self.0.bytes, bytes, MAX_BYTES_IN_FLIGHT)?;
        Ok(ByteReservation { account: self.clone(), bytes })
    }

    /// Starts a reservation of zero bytes for a body.
    pub fn body(&self) -> BodyReservation {
        BodyReservation(self.reserve_unchecked(0))
    }

    /// Reserves bytes even if they do not fit: for data that already exists and has to be sent.
    pub fn reserve_unchecked(&self, bytes: usize) -> ByteReservation {
        self.0.bytes.fetch_add(bytes, Ordering::Relaxed);
        ByteReservation { account: self.clone(), bytes }
    }

    /// Gives an error if the budget is used up.
    pub fn check(&self) -> Result<(), ServerError> {
        if self.is_full() { Err(ServerError::Busy) } else { Ok(()) }
    }

    /// True if the budget is used up.
    pub fn is_full(&self) -> bool {
        self.bytes() >= MAX_BYTES_IN_FLIGHT
    }

    pub fn bytes(&self) -> usize {
        self.0.bytes.load(Ordering::Relaxed)
    }
}

/// Returns the time within which a client has to take an answer of `bytes` bytes.
pub fn delivery_timeout(bytes: usize) -> Duration {
    SEND_TIMEOUT + Duration::from_secs_f64(bytes as f64 / MIN_DELIVERY_BYTES_PER_SECOND as f64)
}

/// Adds bytes to a sum, or gives an error if the sum would exceed the limit. Any number can be added to a sum of zero.
fn try_add(sum: &AtomicUsize, bytes: usize, most: usize) -> Result<(), ServerError> {
    let fits = |held: usize| {
        let sum = held.saturating_add(bytes);
        (held == 0 || sum <= most).then_some(sum)
    };
    let taken = sum.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits);
    taken.map(|_| ()).map_err(|_| ServerError::Busy)
}

impl BodyReservation {
    /// Grows the reservation to at least `bytes`, if that fits.
    pub fn grow_to(&mut self, bytes: usize) -> Result<(), ServerError> {
        let more = bytes.saturating_sub(self.0.bytes);
        let account = &self.0.account.0;
        try_add(&account.body_bytes, more, MAX_BODY_BYTES_IN_FLIGHT)?;
        if let Err(busy) = try_add(&account.bytes, more, MAX_BYTES_IN_FLIGHT) {
            account.body_bytes.fetch_sub(more, Ordering::Relaxed);
            return Err(busy);
        }
        self.0.bytes += more;
        Ok(())
    }
}

impl Drop for BodyReservation {
    fn drop(&mut self) {
        self.0.account.0.body_bytes.fetch_sub(self.0.bytes, Ordering::Relaxed);
    }
}

impl ByteReservation {
    /// Attaches the reservation to bytes. It is freed when their last clone is dropped.
    pub fn attach_to(self, bytes: impl AsRef<[u8]> + Send + 'static) -> Bytes {
        Bytes::from_owner(Owned { bytes, _reservation: self })
    }
}

impl Drop for ByteReservation {
    fn drop(&mut self) {
        self.account.0.bytes.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

struct Owned<T> {
    bytes: T,
    _reservation: ByteReservation,
}

impl<T: AsRef<[u8]>> AsRef<[u8]> for Owned<T> {
    fn as_ref(&self) -> &[u8] {
        self.bytes.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_account_holds_what_fits_and_one_alone_always_does() {
        let account = ByteBudget::default();
        let alone = account.reserve(2 * MAX_BYTES_IN_FLIGHT).unwrap();
        assert!(matches!(account.reserve(1), Err(ServerError::Busy)));
        drop(alone);
        let most = account.reserve(MAX_BYTES_IN_FLIGHT).unwrap();
        assert!(account.reserve(1).is_err() && account.body().grow_to(1).is_err());
        drop(most);
        let counted = account.reserve_unchecked(10).attach_to(vec![0; 10]);
        let clone = counted.clone();
        drop(counted);
        assert_eq!(account.bytes(), 10, "shared bytes count once, until the last clone is gone");
        drop(clone);
        assert_eq!(account.bytes(), 0);
    }

    #[test]
    fn bodies_leave_room_for_answers() {
        let account = ByteBudget::default();
        let mut bodies: Vec<_> = (0..3).map(|_| account.body()).collect();
        bodies[0].grow_to(MAX_BODY_BYTES_IN_FLIGHT / 2).unwrap();
        bodies[1].grow_to(MAX_BODY_BYTES_IN_FLIGHT / 2).unwrap();
        bodies[1].grow_to(1).unwrap();
        assert!(matches!(bodies[2].grow_to(1), Err(ServerError::Busy)));
        assert_eq!(account.bytes(), MAX_BODY_BYTES_IN_FLIGHT, "what was refused is not on the account");
        let answer = account.reserve(MAX_BYTES_IN_FLIGHT - MAX_BODY_BYTES_IN_FLIGHT).unwrap();
        bodies.remove(0);
        bodies[1].grow_to(1).unwrap();
        drop((bodies, answer));
        assert_eq!((account.bytes(), account.0.body_bytes.load(Ordering::Relaxed)), (0, 0));
    }
}

//! Budget for bytes in flight: request bodies until they are answered, and large answers and messages until the client
//! has taken them. All clients share one budget, so the server's memory does not grow with their number. Bodies get
//! half of it, so a client that sends as many bodies as fit does not prevent answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::body::Bytes;

use crate::ServerError;
use crate::limits::{MAX_BODY_BYTES_IN_FLIGHT, MAX_BYTES_IN_FLIGHT, MIN_DELIVERY_BYTES_PER_SECOND, SEND_TIMEOUT};

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
    budget: ByteBudget,
    bytes: usize,
}

/// Reserved bytes of the budget for a body. Dropping the reservation frees them.
#[derive(Debug)]
pub struct BodyReservation(ByteReservation);

impl ByteBudget {
    /// Reserves bytes, or gives an error if they do not fit. Any number of bytes fits if none are reserved.
    pub fn reserve(&self, bytes: usize) -> Result<ByteReservation, ServerError> {
        try_add(&self.0.bytes, bytes, MAX_BYTES_IN_FLIGHT)?;
        Ok(ByteReservation { budget: self.clone(), bytes })
    }

    /// Starts a reservation of zero bytes for a body.
    pub fn body(&self) -> BodyReservation {
        BodyReservation(self.reserve_unchecked(0))
    }

    /// Reserves bytes even if they do not fit: for data that already exists and has to be sent.
    pub fn reserve_unchecked(&self, bytes: usize) -> ByteReservation {
        self.0.bytes.fetch_add(bytes, Ordering::Relaxed);
        ByteReservation { budget: self.clone(), bytes }
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
    let fits = |reserved: usize| {
        let sum = reserved.saturating_add(bytes);
        (reserved == 0 || sum <= most).then_some(sum)
    };
    let taken = sum.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits);
    taken.map(|_| ()).map_err(|_| ServerError::Busy)
}

impl BodyReservation {
    /// Grows the reservation to at least `bytes`, if that fits.
    pub fn grow_to(&mut self, bytes: usize) -> Result<(), ServerError> {
        let more = bytes.saturating_sub(self.0.bytes);
        let budget = &self.0.budget.0;
        try_add(&budget.body_bytes, more, MAX_BODY_BYTES_IN_FLIGHT)?;
        if let Err(busy) = try_add(&budget.bytes, more, MAX_BYTES_IN_FLIGHT) {
            budget.body_bytes.fetch_sub(more, Ordering::Relaxed);
            return Err(busy);
        }
        self.0.bytes += more;
        Ok(())
    }
}

impl Drop for BodyReservation {
    fn drop(&mut self) {
        self.0.budget.0.body_bytes.fetch_sub(self.0.bytes, Ordering::Relaxed);
    }
}

impl ByteReservation {
    /// Attaches the reservation to bytes. It is freed when their last clone is dropped.
    pub fn attach_to(self, bytes: impl AsRef<[u8]> + Send + 'static) -> Bytes {
        guarded_bytes(bytes, self)
    }
}

impl Drop for ByteReservation {
    fn drop(&mut self) {
        self.budget.0.bytes.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// Returns bytes that drop `guard` with their last clone.
pub fn guarded_bytes(bytes: impl AsRef<[u8]> + Send + 'static, guard: impl Send + 'static) -> Bytes {
    Bytes::from_owner(Guarded { bytes, _guard: guard })
}

struct Guarded<T, G> {
    bytes: T,
    _guard: G,
}

impl<T: AsRef<[u8]>, G> AsRef<[u8]> for Guarded<T, G> {
    fn as_ref(&self) -> &[u8] {
        self.bytes.as_ref()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reservations_are_limited_but_a_single_one_always_fits() {
        let budget = ByteBudget::default();
        let alone = budget.reserve(2 * MAX_BYTES_IN_FLIGHT).unwrap();
        assert!(matches!(budget.reserve(1), Err(ServerError::Busy)));
        drop(alone);
        let most = budget.reserve(MAX_BYTES_IN_FLIGHT).unwrap();
        assert!(budget.reserve(1).is_err() && budget.body().grow_to(1).is_err());
        drop(most);
        let counted = budget.reserve_unchecked(10).attach_to(vec![0; 10]);
        let clone = counted.clone();
        drop(counted);
        assert_eq!(budget.bytes(), 10, "shared bytes count once, until the last clone is gone");
        drop(clone);
        assert_eq!(budget.bytes(), 0);
    }

    #[test]
    fn bodies_leave_room_for_answers() {
        let budget = ByteBudget::default();
        let mut bodies: Vec<_> = (0..3).map(|_| budget.body()).collect();
        bodies[0].grow_to(MAX_BODY_BYTES_IN_FLIGHT / 2).unwrap();
        bodies[1].grow_to(MAX_BODY_BYTES_IN_FLIGHT / 2).unwrap();
        bodies[1].grow_to(1).unwrap();
        assert!(matches!(bodies[2].grow_to(1), Err(ServerError::Busy)));
        assert_eq!(budget.bytes(), MAX_BODY_BYTES_IN_FLIGHT, "what was refused is not on the budget");
        let answer = budget.reserve(MAX_BYTES_IN_FLIGHT - MAX_BODY_BYTES_IN_FLIGHT).unwrap();
        bodies.remove(0);
        bodies[1].grow_to(1).unwrap();
        drop((bodies, answer));
        assert_eq!((budget.bytes(), budget.0.body_bytes.load(Ordering::Relaxed)), (0, 0));
    }
}

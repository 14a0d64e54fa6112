//! The account of bytes in flight: requests' bodies until they are answered, and large answers and messages until they
//! are taken. One for all clients, so that no number of them makes the server hold more.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use axum::body::Bytes;

use crate::ServerError;
use crate::limits::{MAX_BYTES_IN_FLIGHT, SEND_WITHIN, TAKEN_BYTES_PER_SECOND};

/// The account. Clones are of the same one.
#[derive(Clone, Debug, Default)]
pub struct InFlight(Arc<AtomicUsize>);

/// Bytes on the account; dropping it takes them off.
#[derive(Debug)]
pub struct Reservation {
    account: InFlight,
    bytes: usize,
}

impl InFlight {
    /// Puts bytes on the account where they fit. Where nothing else is there, anything does.
    pub fn reserve(&self, bytes: usize) -> Result<Reservation, ServerError> {
        let fits = |held: usize| {
            let sum = held.saturating_add(bytes);
            (held == 0 || sum <= MAX_BYTES_IN_FLIGHT).then_some(sum)
        };
        let taken = self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, fits);
        taken.map_err(|_| ServerError::Busy)?;
        Ok(Reservation { account: self.clone(), bytes })
    }

    /// Puts bytes on the account whether they fit or not: what is there already, and has to be sent.
    pub fn count(&self, bytes: usize) -> Reservation {
        self.0.fetch_add(bytes, Ordering::Relaxed);
        Reservation { account: self.clone(), bytes }
    }

    /// Refuses where it is full.
    pub fn check(&self) -> Result<(), ServerError> {
        if self.is_full() { Err(ServerError::Busy) } else { Ok(()) }
    }

    /// Whether nothing more fits.
    pub fn is_full(&self) -> bool {
        self.bytes() >= MAX_BYTES_IN_FLIGHT
    }

    /// What is on it now.
    pub fn bytes(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }
}

/// How long bytes may take to be taken.
pub fn taken_within(bytes: usize) -> Duration {
    SEND_WITHIN + Duration::from_secs_f64(bytes as f64 / TAKEN_BYTES_PER_SECOND as f64)
}

impl Reservation {
    /// Makes it as large as `bytes` at least, where that fits.
    pub fn grow_to(&mut self, bytes: usize) -> Result<(), ServerError> {
        let more = bytes.saturating_sub(self.bytes);
        let mut added = self.account.reserve(more)?;
        self.bytes += std::mem::take(&mut added.bytes);
        Ok(())
    }

    /// The same bytes, on the account until the last clone of them is dropped.
    pub fn of(self, bytes: impl AsRef<[u8]> + Send + 'static) -> Bytes {
        Bytes::from_owner(Owned { bytes, _reservation: self })
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.account.0.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

struct Owned<T> {
    bytes: T,
    _reservation: Reservation,
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
        let account = InFlight::default();
        let alone = account.reserve(2 * MAX_BYTES_IN_FLIGHT).unwrap();
        assert!(matches!(account.reserve(1), Err(ServerError::Busy)));
        drop(alone);
        let mut half = account.reserve(MAX_BYTES_IN_FLIGHT / 2).unwrap();
        assert!(half.grow_to(MAX_BYTES_IN_FLIGHT + 1).is_err());
        half.grow_to(MAX_BYTES_IN_FLIGHT).unwrap();
        assert_eq!(account.bytes(), MAX_BYTES_IN_FLIGHT);
        let counted = account.count(10).of(vec![0; 10]);
        let clone = counted.clone();
        drop((half, counted));
        assert_eq!(account.bytes(), 10, "shared bytes count once, until the last clone is gone");
        drop(clone);
        assert_eq!(account.bytes(), 0);
    }
}

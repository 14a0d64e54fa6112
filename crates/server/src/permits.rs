//! Permits that requests hold while they are in progress. No session can take the last one.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::ServerError;

/// A fixed number of permits. A session can take one while it has fewer than are free. So a session alone gets half of
/// them, and the next one finds some (the dynamic threshold of Choudhury and Hahne, 1998, for buffers that ports
/// share).
#[derive(Debug)]
pub struct SessionPermits {
    /// Plural name of the limited things in error messages: requests, pictures.
    label: &'static str,
    limit: usize,
    /// Number of permits that each session holds. Requests without a session count under an empty name.
    taken: Mutex<BTreeMap<String, usize>>,
}

/// A permit of a session, returned when this is dropped.
#[derive(Debug)]
pub struct Permit<'a> {
    permits: &'a SessionPermits,
    session: String,
}

impl SessionPermits {
    pub fn new(label: &'static str, limit: usize) -> Self {
        Self { label, limit, taken: Mutex::default() }
    }

    /// Takes a permit for a session, or gives an error if the session may hold no more.
    pub fn acquire(&self, session: &str) -> Result<Permit<'_>, ServerError> {
        let mut taken = self.taken();
        let free = self.limit - taken.values().sum::<usize>();
        let own = taken.get(session).copied().unwrap_or_default();
        if own >= free {
            return Err(match (free, session) {
                (0, _) => ServerError::TooMany { what: self.label, limit: self.limit },
                (_, "") => ServerError::TooMany { what: self.label, limit: own },
                _ => ServerError::SessionLimitReached { what: self.label, count: own },
            });
        }
        taken.insert(session.to_owned(), own + 1);
        Ok(Permit { permits: self, session: session.to_owned() })
    }

    fn taken(&self) -> MutexGuard<'_, BTreeMap<String, usize>> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Permit<'_> {
    fn drop(&mut self) {
        let mut taken = self.permits.taken();
        match taken.get_mut(&self.session) {
            Some(own) if *own > 1 => *own -= 1,
            _ => drop(taken.remove(&self.session)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the number of permits that each of these sessions gets if they take as many as they can, one session
    /// after the other.
    fn taken(most: usize, sessions: &[&str]) -> Vec<usize> {
        let permits = SessionPermits::new("pictures", most);
        let mut permits_of_all = Vec::new();
        let count = |session: &&str| {
            let own: Vec<_> = std::iter::from_fn(|| permits.acquire(session).ok()).collect();
            let count = own.len();
            permits_of_all.extend(own);
            count
        };
        let counts = sessions.iter().map(count).collect();
        drop(permits_of_all);
        assert!(permits.taken().is_empty(), "all come back");
        counts
    }

    #[test]
    fn no_session_takes_all() {
        assert_eq!(taken(8, &["greedy", "other", "third", "fourth"]), [4, 2, 1, 1]);
        assert_eq!(taken(64, &["greedy", "other"]), [32, 16]);
        let permits = SessionPermits::new("pictures", 2);
        let _one = permits.acquire("greedy").expect("free");
        let refused = permits.acquire("greedy").expect_err("the last is another's");
        assert!(matches!(refused, ServerError::SessionLimitReached { count: 1, .. }), "{refused}");
        // A request without a session gets an error that names none.
        let nobodys = SessionPermits::new("requests", 2);
        let _first = nobodys.acquire("").expect("free");
        assert!(matches!(nobodys.acquire(""), Err(ServerError::TooMany { limit: 1, .. })));
        let _other = permits.acquire("other").expect("free");
        assert!(matches!(permits.acquire("third"), Err(ServerError::TooMany { limit: 2, .. })));
    }
}

//! Allowances: limits of consumption per client that refill with time.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::charges::{MAX_ACCOUNTS, Payer};

/// Refill rate and capacity of a token bucket.
#[derive(Clone, Copy, Debug)]
pub struct AllowanceRate {
    pub per_second: f64,
    pub burst: f64,
}

/// A token bucket.
#[derive(Clone, Copy, Debug)]
pub struct Allowance {
    rate: AllowanceRate,
    /// Tokens left at `updated_at`. Negative if more was taken.
    tokens: f64,
    updated_at: Instant,
}

/// Token buckets of all sessions and all actors. A request takes tokens from the buckets of both its session and its
/// actor.
#[derive(Debug)]
pub struct Allowances {
    rate: AllowanceRate,
    /// Buckets that are not full, by session. The next field has those of actors.
    sessions: BTreeMap<Arc<str>, Allowance>,
    actors: BTreeMap<Arc<str>, Allowance>,
}

impl Allowance {
    /// Makes a full bucket.
    pub fn full(rate: AllowanceRate, now: Instant) -> Self {
        Self { rate, tokens: rate.burst, updated_at: now }
    }

    fn left(&self, now: Instant) -> f64 {
        let since = now.saturating_duration_since(self.updated_at).as_secs_f64();
        (self.tokens + self.rate.per_second * since).min(self.rate.burst)
    }

    /// Returns the time at which the bucket has tokens: at most `now` if it has some.
    fn back_at(&self, now: Instant) -> Instant {
        now + Duration::from_secs_f64((-self.left(now) / self.rate.per_second).max(0.0))
    }

    /// Takes `amount` tokens if at least some are left; the rest becomes debt. Otherwise returns the time at which
    /// there will be tokens.
    pub fn try_take(&mut self, amount: f64, now: Instant) -> Result<(), Instant> {
        let back_at = self.back_at(now);
        if back_at > now {
            return Err(back_at);
        }
        self.take(amount, now);
        Ok(())
    }

    /// Takes `amount` tokens, even if fewer are left.
    pub fn take(&mut self, amount: f64, now: Instant) {
        (self.tokens, self.updated_at) = (self.left(now) - amount, now);
    }
}

impl Allowances {
    /// Makes buckets that are all full.
    pub fn new(rate: AllowanceRate) -> Self {
        Self { rate, sessions: BTreeMap::new(), actors: BTreeMap::new() }
    }

    /// True if a payer has tokens.
    pub fn has_tokens(&self, payer: &Payer, now: Instant) -> bool {
        self.back_at(payer, now) <= now
    }

    /// Returns the time at which a payer has tokens: at most `now` if it has some.
    fn back_at(&self, payer: &Payer, now: Instant) -> Instant {
        let back_at = |allowance: Option<&Allowance>| allowance.map_or(now, |of| of.back_at(now));
        let of_actor = payer.actor_id().and_then(|actor| self.actors.get(actor));
        back_at(self.sessions.get(payer.session())).max(back_at(of_actor))
    }

    /// Takes `amount` tokens from a payer if at least some are left; the rest becomes debt. Otherwise returns the time
    /// at which there will be tokens.
    pub fn try_take(&mut self, payer: &Payer, amount: f64, now: Instant) -> Result<(), Instant> {
        let back_at = self.back_at(payer, now);
        if back_at > now {
            return Err(back_at);
        }
        self.take(payer, amount, now);
        Ok(())
    }

    /// Takes `amount` tokens from a payer, even if fewer are left.
    pub fn take(&mut self, payer: &Payer, amount: f64, now: Instant) {
        let take = |accounts: &mut BTreeMap<Arc<str>, Allowance>, name: &Arc<str>| {
            let full = Allowance::full(self.rate, now);
            accounts.entry(Arc::clone(name)).or_insert(full).take(amount, now);
            if accounts.len() > MAX_ACCOUNTS {
                let mut all: Vec<f64> = accounts.values().map(|of| of.left(now)).collect();
                all.sort_by(f64::total_cmp);
                // Forgets the half with the most tokens, whose allowances are full again.
                accounts.retain(|_, of| of.left(now) < all[all.len() / 2]);
            }
        };
        take(&mut self.sessions, payer.session());
        if let Some(actor) = payer.actor_id() {
            take(&mut self.actors, actor);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::charges::tests::payer;

    #[test]
    fn an_allowance_is_used_up_and_comes_back() {
        let rate = AllowanceRate { per_second: 0.1, burst: 0.2 };
        let (mut allowances, start) = (Allowances::new(rate), Instant::now());
        let (ada, other) = (payer("shot", "ada"), payer("other", "ben"));
        let (mut used, mut now) = (0.0, start);
        // For a hundred seconds, one request every 10 ms.
        while now < start + Duration::from_secs(100) {
            now += Duration::from_millis(10);
            if allowances.has_tokens(&ada, now) {
                allowances.take(&ada, 0.01, now);
                used += 0.01;
            }
        }
        let most = rate.burst + 100.0 * rate.per_second + 0.01;
        assert!(used <= most && used > 0.95 * most, "{used} of {most}");
        allowances.take(&ada, rate.burst, now);
        // Another actor of the session and the same actor in another session share the allowance. Others do not.
        assert!(!allowances.has_tokens(&payer("shot", "eve"), now));
        assert!(!allowances.has_tokens(&payer("elsewhere", "ada"), now));
        assert!(allowances.has_tokens(&other, now));
        let back_at = allowances.back_at(&ada, now);
        assert!(!allowances.has_tokens(&ada, now + back_at.duration_since(now) / 2));
        assert!(allowances.has_tokens(&ada, back_at + Duration::from_millis(1)));
        for name in 0..10_000 {
            // All take the same amount at once, so nothing refills meanwhile.
            allowances.take(&payer("shot", &name.to_string()), 0.001, now);
        }
        assert!(allowances.actors.len() <= MAX_ACCOUNTS + 1, "{}", allowances.actors.len());
        assert!(!allowances.has_tokens(&payer("shot", "new"), now), "another name is the same session");
    }
}

//! Charges: time that clients have used of the renderer or of solver threads. They decide which client is next.
//!
//! A client is charged for measured time. The least charged client is next: first the least charged session, so that
//! many clients of one session get no more than the few clients of another, then the least charged actor of the
//! session. An actor is one client, whatever its number of sockets and sessions. Callers pass in the time.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Greatest number of sessions, and of actors, whose charges are kept. Above it the less charged half is dropped.
pub const MAX_ACCOUNTS: usize = 256;

/// Seconds of credit that a client can save while it is idle. A user who drags requests nothing while a picture is on
/// its way to the viewer. But other clients also save, and then draw that much at once: beside views that open 30 at a
/// time, the longest gap of a drag is 92 ms with 50 ms of credit and 70 ms with these 30 ms, for as many pictures.
const MAX_CREDIT_SECONDS: f64 = 0.03;

/// An actor in a session that is charged for work.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Payer {
    /// Name of the session.
    session: Arc<str>,
    /// Id of the actor. `None` for a program that gives none.
    actor: Option<Arc<str>>,
}

/// Seconds charged to each session and each actor.
///
/// This is start-time fair queueing (Goyal, Vin, Cheng, 1996) with equal weights. A client that was idle starts at the
/// charge of those that were served lately, less [`MAX_CREDIT_SECONDS`].
#[derive(Clone, Debug, Default)]
pub struct Charges {
    sessions: Accounts,
    actors: Accounts,
}

/// Charged seconds by the name of each session, or of each actor.
#[derive(Clone, Debug, Default)]
struct Accounts {
    seconds: BTreeMap<Arc<str>, f64>,
    /// Charge at which a new session or actor starts: the greatest charge that one had when it was served.
    virtual_time: f64,
}

/// Charges of a payer. The first number is the greater one of the payer's session and actor, the second is the actor's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChargedSeconds(f64, f64);

impl Payer {
    pub fn new(session: &Arc<str>, actor: &str) -> Self {
        Self { session: Arc::clone(session), actor: Some(actor.into()) }
    }

    /// Returns the id of the actor, if it gives one.
    pub fn actor_id(&self) -> Option<&Arc<str>> {
        self.actor.as_ref()
    }

    /// Returns the name of the session.
    pub fn session(&self) -> &Arc<str> {
        &self.session
    }

    /// Makes the payer for programs that name no actor.
    pub fn program(session: &str) -> Self {
        Self { session: session.into(), actor: None }
    }
}

impl ChargedSeconds {
    /// Orders two payers by their charges. The lower charge is next.
    pub fn order(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(self.1.total_cmp(&other.1))
    }
}

impl Charges {
    /// Returns the present charges of a payer.
    pub fn of(&self, payer: &Payer) -> ChargedSeconds {
        let session = self.sessions.of(&payer.session);
        let actor = payer.actor.as_deref().map_or(session, |actor| self.actors.of(actor));
        ChargedSeconds(session.max(actor), actor)
    }

    /// Charges a payer for `seconds` of drawing or solving.
    pub fn charge(&mut self, payer: &Payer, seconds: f64) {
        self.sessions.charge(&payer.session, seconds);
        if let Some(actor) = &payer.actor {
            self.actors.charge(actor, seconds);
        }
    }
}

impl Accounts {
    fn of(&self, name: &str) -> f64 {
        // A new name has no credit. Otherwise a new name for each picture would always be first.
        self.seconds.get(name).map_or(self.virtual_time, |charged| charged.max(self.virtual_time - MAX_CREDIT_SECONDS))
    }

    fn charge(&mut self, name: &Arc<str>, seconds: f64) {
        let before = self.of(name);
        self.virtual_time = self.virtual_time.max(before);
        self.seconds.insert(Arc::clone(name), before + seconds);
        if self.seconds.len() > MAX_ACCOUNTS {
            // Drops the lower half, which starts from a common level now.
            let mut all: Vec<f64> = self.seconds.values().copied().collect();
            all.sort_by(f64::total_cmp);
            self.virtual_time = self.virtual_time.max(all[all.len() / 2]);
            self.seconds.retain(|_, charged| *charged > self.virtual_time);
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    pub fn payer(session: &str, actor: &str) -> Payer {
        Payer::new(&session.into(), actor)
    }

    /// Returns the share of the time that each of `payers` gets in `turns` slices, if all always want a slice. The
    /// second value of each is the length of its slices.
    fn shares(payers: &[(Payer, f64)], turns: usize) -> Vec<f64> {
        let mut charges = Charges::default();
        let mut seconds = vec![0.0; payers.len()];
        for _ in 0..turns {
            let charge = |index: &usize| charges.of(&payers[*index].0);
            let next = (0..payers.len()).min_by(|a, b| charge(a).order(&charge(b))).expect("somebody");
            charges.charge(&payers[next].0, payers[next].1);
            seconds[next] += payers[next].1;
        }
        let total: f64 = seconds.iter().sum();
        seconds.iter().map(|seconds| seconds / total).collect()
    }

    #[test]
    fn one_client_has_half_beside_another_with_any_number_of_sockets() {
        let victim = (payer("shot", "ada"), 0.02);
        for seconds in [0.001, 0.01, 0.4] {
            // One actor in one session, many actors in one session, one actor in many sessions.
            let same = vec![(payer("other", "bob"), seconds); 8];
            let actors: Vec<_> = (0..8).map(|k| (payer("other", &k.to_string()), seconds)).collect();
            let sessions: Vec<_> = (0..8).map(|k| (payer(&k.to_string(), "bob"), seconds)).collect();
            for others in [same, actors, sessions] {
                let share = shares(&[vec![victim.clone()], others].concat(), 10_000)[0];
                assert!((share - 0.5).abs() < 0.03, "{share} beside turns of {seconds} s");
            }
        }
    }

    #[test]
    fn within_a_session_actors_have_the_same() {
        let of = |actor: &str| (payer("shot", actor), 0.01);
        let shares = shares(&[of("ada"), of("bob"), of("bob"), of("bob")], 1_000);
        assert!((shares[0] - 0.5).abs() < 0.01, "{shares:?}");
    }

    /// Deliberate fault that the test must detect: a client that comes back with a charge of zero makes another wait
    /// for as long as it was away.
    #[test]
    fn an_idle_client_saves_little_credit() {
        let (ada, bob) = (payer("shot", "ada"), payer("other", "bob"));
        let mut charges = Charges::default();
        (0..1_000).for_each(|_| charges.charge(&ada, 0.01));
        let mut turns = 0;
        while charges.of(&bob).order(&charges.of(&ada)).is_le() {
            charges.charge(&bob, 0.01);
            turns += 1;
        }
        // Turns of 10 ms each, and three turns at equal charges.
        let most = (MAX_CREDIT_SECONDS / 0.01) as usize + 3;
        assert!((1..=most).contains(&turns), "{turns} turns before the other goes on");
        charges.sessions.virtual_time = 0.0;
        charges.actors.virtual_time = 0.0;
        let late = payer("late", "eve");
        assert!(charges.of(&late).order(&charges.of(&ada)).is_lt() && charges.of(&late) == ChargedSeconds(0.0, 0.0));
    }

    #[test]
    fn accounts_are_bounded() {
        let mut charges = Charges::default();
        for k in 0..10_000 {
            charges.charge(&payer(&k.to_string(), &k.to_string()), 0.01);
        }
        assert!(charges.sessions.seconds.len() <= MAX_ACCOUNTS + 1);
    }
}

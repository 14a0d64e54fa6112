//! Who draws next, and for how long. Knows no device and no clock.
//!
//! Of what is as urgent the client goes next that has been charged least (`crate::turns`), and of that client's what has waited
//! longest. What a hand moves comes first. While one does, the views of those who only watch get a share of the time; while
//! something moves at all, so do pictures of views at rest, and stills: what they have not used they are owed, and once
//! that is enough for a turn they get it, though something more urgent waits. Views at rest go before stills in the same
//! way. Where nothing more urgent goes on, there are no shares.

use std::time::{Duration, Instant};

use crate::charges::ChargedSeconds;
use crate::limits::{
    MAX_TURN, MOVING_FOR, MOVING_TURN, SETTLING_TIME_SHARE, TURN_WHILE_MOVING, WATCHED_TIME_SHARE,
};

/// What is more urgent is drawn first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// A view in which something moves, of whoever moves it.
    Moving,
    /// A view in which somebody else moves something.
    Watched,
    /// A view at rest.
    Settling,
    /// Nobody sees it grow.
    Still,
}

impl Urgency {
    /// Each, the most urgent first.
    pub const ALL: [Self; 4] = [Self::Moving, Self::Watched, Self::Settling, Self::Still];

    /// Its name in `/metrics`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::Watched => "watched",
            Self::Settling => "settling",
            Self::Still => "still",
        }
    }

    /// Whether something moves in the picture.
    pub fn is_moving(self) -> bool {
        matches!(self, Self::Moving | Self::Watched)
    }
}

/// A picture that waits.
#[derive(Clone, Copy, Debug)]
pub struct QueuedPicture {
    /// How urgent it is.
    pub urgency: Urgency,
    /// What whoever it is drawn for has been charged.
    pub charged: ChargedSeconds,
    /// When it was last worked on, or since when it waits.
    pub last_turn_at: Instant,
    /// Since when it waits, worked on or not.
    pub queued_at: Instant,
}

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScheduledTurn {
    /// Work on the picture of this index for about so long.
    Draw(usize, Duration),
    /// Nothing may be drawn before so much time has passed; something new may.
    Wait(Duration),
    /// There is nothing to draw.
    Idle,
}

/// The classes that have an account, most urgent first, with their shares of the time.
const SHARES: [(Urgency, f64); 3] = [
    (Urgency::Watched, WATCHED_TIME_SHARE),
    (Urgency::Settling, SETTLING_TIME_SHARE),
    (Urgency::Still, SETTLING_TIME_SHARE),
];

/// What it remembers from turn to turn.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// When a hand last moved something, and when something last moved at all.
    last_interactive: Option<Instant>,
    last_moving: Option<Instant>,
    /// Seconds that those who watch, views at rest and stills are owed; below zero they have had more than their share.
    owed_seconds: [f64; SHARES.len()],
    /// Until when that was reckoned.
    accrued_until: Option<Instant>,
    /// As what the turn was given that is not over: its account pays, whatever is drawn in it.
    turn_class: Option<Urgency>,
}

impl Schedule {
    /// Nothing has been drawn.
    pub fn new() -> Self {
        let (last_interactive, last_moving, owed_seconds, accrued_until) =
            (None, None, [0.0; SHARES.len()], None);
        Self { last_interactive, last_moving, owed_seconds, accrued_until, turn_class: None }
    }

    /// Whose turn it is.
    pub fn next(&mut self, now: Instant, waiting: &[QueuedPicture]) -> ScheduledTurn {
        let waits = |urgency| waiting.iter().any(|task| task.urgency == urgency);
        if waits(Urgency::Moving) {
            self.last_interactive = Some(now);
        }
        if waits(Urgency::Moving) || waits(Urgency::Watched) {
            self.last_moving = Some(now);
        }
        let lately = |moved: Option<Instant>| {
            moved.is_some_and(|moved| now.saturating_duration_since(moved) < MOVING_FOR)
        };
        let (hand_moves, moves) = (lately(self.last_interactive), lately(self.last_moving));
        let limited = [hand_moves, moves, moves || waits(Urgency::Settling)];
        let turn = if moves { TURN_WHILE_MOVING } else { MAX_TURN };
        self.accrue_shares(now, SHARES.map(|(urgency, _)| waits(urgency)), limited, turn);

        let turn = self.choose(waiting, limited, turn);
        self.turn_class = match turn {
            ScheduledTurn::Draw(index, _) => Some(waiting[index].urgency),
            ScheduledTurn::Wait(_) | ScheduledTurn::Idle => None,
        };
        turn
    }

    /// Whose turn it is, where these classes are `limited` to their shares.
    fn choose(
        &self,
        waiting: &[QueuedPicture],
        limited: [bool; SHARES.len()],
        turn: Duration,
    ) -> ScheduledTurn {
        // What is owed longest first, though it is the least urgent.
        for (index, (urgency, _)) in SHARES.iter().enumerate().rev() {
            if limited[index]
                && self.owed_seconds[index] >= turn.as_secs_f64()
                && let Some(first) = least_charged(waiting, *urgency)
            {
                return ScheduledTurn::Draw(first, turn);
            }
        }
        let unlimited = SHARES.iter().zip(limited).filter(|(_, limited)| !limited).map(|(share, _)| share.0);
        if let Some(first) = least_charged(waiting, Urgency::Moving) {
            return ScheduledTurn::Draw(first, MOVING_TURN);
        }
        for urgency in unlimited {
            if let Some(first) = least_charged(waiting, urgency) {
                return ScheduledTurn::Draw(first, turn);
            }
        }
        if waiting.is_empty() {
            return ScheduledTurn::Idle;
        }
        let waits_for = waiting.iter().filter_map(|task| account_index(task.urgency));
        let missing =
            waits_for.map(|index| (turn.as_secs_f64() - self.owed_seconds[index]).max(0.0) / SHARES[index].1);
        let least = missing.fold(f64::INFINITY, f64::min);
        ScheduledTurn::Wait(Duration::from_secs_f64(least).clamp(Duration::from_millis(1), MOVING_FOR))
    }

    /// A turn is over; it went on from `began` to `ended`. What was drawn can be of another class than who got the turn: a
    /// scene's thread ends first what it is in the middle of.
    pub fn record_turn(&mut self, urgency: Urgency, [began, ended]: [Instant; 2]) {
        let took = ended.saturating_duration_since(began);
        if urgency == Urgency::Moving {
            self.last_interactive = Some(ended);
        }
        if urgency.is_moving() {
            self.last_moving = Some(ended);
        }
        if let Some(index) = self.turn_class.take().and_then(account_index) {
            self.owed_seconds[index] -= took.as_secs_f64();
        }
    }

    /// Adds the share of the time since the last reckoning, at most to what one turn takes: nobody saves up.
    fn accrue_shares(
        &mut self,
        now: Instant,
        waits: [bool; SHARES.len()],
        limited: [bool; SHARES.len()],
        turn: Duration,
    ) {
        let since = self.accrued_until.map_or(Duration::ZERO, |then| now.saturating_duration_since(then));
        self.accrued_until = Some(now);
        for (index, owed) in self.owed_seconds.iter_mut().enumerate() {
            let earned = SHARES[index].1 * since.as_secs_f64();
            *owed = match (limited[index], waits[index]) {
                (true, true) => (*owed + earned).min(turn.as_secs_f64()),
                // Debts are paid off also while nobody waits.
                (true, false) => (*owed + earned).min(0.0),
                (false, _) => 0.0,
            };
        }
    }
}

/// Where the account of a class stands; `None` of what a hand moves, which needs none.
fn account_index(urgency: Urgency) -> Option<usize> {
    SHARES.iter().position(|(class, _)| *class == urgency)
}

fn least_charged(waiting: &[QueuedPicture], urgency: Urgency) -> Option<usize> {
    let of_it = waiting.iter().enumerate().filter(|(_, task)| task.urgency == urgency);
    // Of what one client watches the oldest is drawn to its end: of thirty views that are opened at once, a turn each in turn, none
    // would show anything for long.
    let waits_from =
        |task: &QueuedPicture| if urgency == Urgency::Watched { task.queued_at } else { task.last_turn_at };
    let order = |a: &QueuedPicture, b: &QueuedPicture| {
        a.charged.order(&b.charged).then(waits_from(a).cmp(&waits_from(b)))
    };
    Some(of_it.min_by(|(_, a), (_, b)| order(a, b))?.0)
}

#[cfg(test)]
mod tests;

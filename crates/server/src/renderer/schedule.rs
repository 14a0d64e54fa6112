//! Who draws next, and for how long. Knows no device and no clock.
//!
//! Of what is as urgent the client goes next that has been charged least (`crate::turns`), and of that client's what has waited
//! longest. What a hand moves comes first. While one does, the views of those who only watch get a share of the time; while
//! something moves at all, so do pictures of views at rest, and stills: what they have not used they are owed, and once
//! that is enough for a turn they get it, though something more urgent waits. Views at rest go before stills in the same
//! way. Where nothing more urgent goes on, there are no shares.

use std::time::{Duration, Instant};

use crate::limits::{MOVING_FOR, MOVING_TURN, REST_SHARE, TURN_AT_MOST, TURN_WHILE_MOVING, WATCH_SHARE};
use crate::turns::Charged;

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
    pub fn moves(self) -> bool {
        matches!(self, Self::Moving | Self::Watched)
    }
}

/// A picture that waits.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    /// How urgent it is.
    pub urgency: Urgency,
    /// What whoever it is drawn for has been charged.
    pub charged: Charged,
    /// When it was last worked on, or since when it waits.
    pub touched: Instant,
    /// Since when it waits, worked on or not.
    pub since: Instant,
}

/// What to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Work on the picture of this index for about so long.
    Draw(usize, Duration),
    /// Nothing may be drawn before so much time has passed; something new may.
    Wait(Duration),
    /// There is nothing to draw.
    Idle,
}

/// The classes that have an account, most urgent first, with their shares of the time.
const SHARES: [(Urgency, f64); 3] =
    [(Urgency::Watched, WATCH_SHARE), (Urgency::Settling, REST_SHARE), (Urgency::Still, REST_SHARE)];

/// What it remembers from turn to turn.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// When a hand last moved something, and when something last moved at all.
    hand_moved: Option<Instant>,
    moved: Option<Instant>,
    /// Seconds that those who watch, views at rest and stills are owed; below zero they have had more than their share.
    owed: [f64; SHARES.len()],
    /// Until when that was reckoned.
    reckoned: Option<Instant>,
    /// As what the turn was given that is not over: its account pays, whatever is drawn in it.
    turn_of: Option<Urgency>,
}

impl Schedule {
    /// Nothing has been drawn.
    pub fn new() -> Self {
        let (hand_moved, moved, owed, reckoned) = (None, None, [0.0; SHARES.len()], None);
        Self { hand_moved, moved, owed, reckoned, turn_of: None }
    }

    /// Whose turn it is.
    pub fn next(&mut self, now: Instant, waiting: &[Waiting]) -> Turn {
        let waits = |urgency| waiting.iter().any(|task| task.urgency == urgency);
        if waits(Urgency::Moving) {
            self.hand_moved = Some(now);
        }
        if waits(Urgency::Moving) || waits(Urgency::Watched) {
            self.moved = Some(now);
        }
        let lately = |moved: Option<Instant>| {
            moved.is_some_and(|moved| now.saturating_duration_since(moved) < MOVING_FOR)
        };
        let (hand_moves, moves) = (lately(self.hand_moved), lately(self.moved));
        let limited = [hand_moves, moves, moves || waits(Urgency::Settling)];
        let turn = if moves { TURN_WHILE_MOVING } else { TURN_AT_MOST };
        self.reckon(now, SHARES.map(|(urgency, _)| waits(urgency)), limited, turn);

        let turn = self.choose(waiting, limited, turn);
        self.turn_of = match turn {
            Turn::Draw(index, _) => Some(waiting[index].urgency),
            Turn::Wait(_) | Turn::Idle => None,
        };
        turn
    }

    /// Whose turn it is, where these classes are `limited` to their shares.
    fn choose(&self, waiting: &[Waiting], limited: [bool; SHARES.len()], turn: Duration) -> Turn {
        // What is owed longest first, though it is the least urgent.
        for (index, (urgency, _)) in SHARES.iter().enumerate().rev() {
            if limited[index]
                && self.owed[index] >= turn.as_secs_f64()
                && let Some(first) = least_charged(waiting, *urgency)
            {
                return Turn::Draw(first, turn);
            }
        }
        let unlimited = SHARES.iter().zip(limited).filter(|(_, limited)| !limited).map(|(share, _)| share.0);
        if let Some(first) = least_charged(waiting, Urgency::Moving) {
            return Turn::Draw(first, MOVING_TURN);
        }
        for urgency in unlimited {
            if let Some(first) = least_charged(waiting, urgency) {
                return Turn::Draw(first, turn);
            }
        }
        if waiting.is_empty() {
            return Turn::Idle;
        }
        let waits_for = waiting.iter().filter_map(|task| account(task.urgency));
        let missing =
            waits_for.map(|index| (turn.as_secs_f64() - self.owed[index]).max(0.0) / SHARES[index].1);
        let least = missing.fold(f64::INFINITY, f64::min);
        Turn::Wait(Duration::from_secs_f64(least).clamp(Duration::from_millis(1), MOVING_FOR))
    }

    /// A turn is over; it went on from `began` to `ended`. What was drawn can be of another class than who got the turn: a
    /// scene's thread ends first what it is in the middle of.
    pub fn note(&mut self, urgency: Urgency, [began, ended]: [Instant; 2]) {
        let took = ended.saturating_duration_since(began);
        if urgency == Urgency::Moving {
            self.hand_moved = Some(ended);
        }
        if urgency.moves() {
            self.moved = Some(ended);
        }
        if let Some(index) = self.turn_of.take().and_then(account) {
            self.owed[index] -= took.as_secs_f64();
        }
    }

    /// Adds the share of the time since the last reckoning, at most to what one turn takes: nobody saves up.
    fn reckon(
        &mut self,
        now: Instant,
        waits: [bool; SHARES.len()],
        limited: [bool; SHARES.len()],
        turn: Duration,
    ) {
        let since = self.reckoned.map_or(Duration::ZERO, |then| now.saturating_duration_since(then));
        self.reckoned = Some(now);
        for (index, owed) in self.owed.iter_mut().enumerate() {
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
fn account(urgency: Urgency) -> Option<usize> {
    SHARES.iter().position(|(class, _)| *class == urgency)
}

fn least_charged(waiting: &[Waiting], urgency: Urgency) -> Option<usize> {
    let of_it = waiting.iter().enumerate().filter(|(_, task)| task.urgency == urgency);
    // Of what one client watches the oldest is drawn to its end: of thirty views that are opened at once, a turn each in turn, none
    // would show anything for long.
    let waits_from = |task: &Waiting| if urgency == Urgency::Watched { task.since } else { task.touched };
    let order =
        |a: &Waiting, b: &Waiting| a.charged.order(&b.charged).then(waits_from(a).cmp(&waits_from(b)));
    Some(of_it.min_by(|(_, a), (_, b)| order(a, b))?.0)
}

#[cfg(test)]
mod tests;

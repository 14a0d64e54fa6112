//! Choice of the next turn and its length. Knows no device and no clock.
//!
//! Among equally urgent pictures the least charged client is next (`crate::charges`), and of that client the picture
//! that has waited longest. Views that a user moves come first. While a user moves one, views of those who only watch
//! get a share of the time. While anything moves at all, views at rest and stills get one too. Unused shares are owed.
//! Once a class is owed enough for a turn, it gets the turn before more urgent pictures. Views at rest precede stills
//! in the same way. There are no shares while nothing more urgent is drawn.

use std::time::{Duration, Instant};

use crate::charges::ChargedSeconds;
use crate::limits::{
    MAX_TURN, MOVING_FOR, MOVING_TURN, SETTLING_TIME_SHARE, TURN_WHILE_MOVING, WATCHED_TIME_SHARE,
};

/// Urgency of a picture. More urgent pictures are drawn first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// A view in which its viewer moves something.
    Moving,
    /// A view in which another user moves something.
    Watched,
    /// A view at rest.
    Settling,
    /// A still. Nobody sees it unfinished.
    Still,
}

impl Urgency {
    /// All classes, the most urgent first.
    pub const ALL: [Self; 4] = [Self::Moving, Self::Watched, Self::Settling, Self::Still];

    /// Name in `/metrics`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Moving => "moving",
            Self::Watched => "watched",
            Self::Settling => "settling",
            Self::Still => "still",
        }
    }

    /// True if something moves in the picture.
    pub fn is_moving(self) -> bool {
        matches!(self, Self::Moving | Self::Watched)
    }
}

/// A picture that waits.
#[derive(Clone, Copy, Debug)]
pub struct QueuedPicture {
    pub urgency: Urgency,
    /// Charges of its client so far.
    pub charged: ChargedSeconds,
    /// End of its latest turn, or the start of its wait.
    pub last_turn_at: Instant,
    /// Start of its wait, with or without turns since.
    pub queued_at: Instant,
}

/// Decision of the schedule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScheduledTurn {
    /// Draw the picture of this index for about that time.
    Draw(usize, Duration),
    /// Draw no waiting picture before that time has passed. A new one may be drawn.
    Wait(Duration),
    Idle,
}

/// The classes with an account, most urgent first, with their shares of the time.
const SHARES: [(Urgency, f64); 3] = [
    (Urgency::Watched, WATCHED_TIME_SHARE),
    (Urgency::Settling, SETTLING_TIME_SHARE),
    (Urgency::Still, SETTLING_TIME_SHARE),
];

/// State of the schedule between turns.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// Times at which a user last moved something in their own view, and at which anything last moved.
    last_interactive: Option<Instant>,
    last_moving: Option<Instant>,
    /// Seconds owed to watched views, views at rest and stills. Negative if a class had more than its share.
    owed_seconds: [f64; SHARES.len()],
    /// Time up to which `owed_seconds` is computed.
    accrued_until: Option<Instant>,
    /// Class that got the current turn. Its account pays, whatever is drawn in the turn.
    turn_class: Option<Urgency>,
}

impl Schedule {
    /// Starts with empty accounts.
    pub fn new() -> Self {
        let (last_interactive, last_moving, owed_seconds, accrued_until) =
            (None, None, [0.0; SHARES.len()], None);
        Self { last_interactive, last_moving, owed_seconds, accrued_until, turn_class: None }
    }

    /// Chooses the next turn.
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

    /// Chooses the next turn if these classes are `limited` to their shares.
    fn choose(
        &self,
        waiting: &[QueuedPicture],
        limited: [bool; SHARES.len()],
        turn: Duration,
    ) -> ScheduledTurn {
        // Owed turns come first, starting with the least urgent class.
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

    /// Notes a turn from `began` to `ended`. The drawn picture can be of another class than the one that got the turn,
    /// since the thread of a scene first finishes the picture in progress.
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

    /// Adds the shares of the time since the last call. An account holds at most one turn, so no class saves up.
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
                // Debts are paid off even while the class has no waiting picture.
                (true, false) => (*owed + earned).min(0.0),
                (false, _) => 0.0,
            };
        }
    }
}

/// Index of the account of a class. `None` for views that a user moves, which need none.
fn account_index(urgency: Urgency) -> Option<usize> {
    SHARES.iter().position(|(class, _)| *class == urgency)
}

fn least_charged(waiting: &[QueuedPicture], urgency: Urgency) -> Option<usize> {
    let of_it = waiting.iter().enumerate().filter(|(_, task)| task.urgency == urgency);
    // The oldest picture of a client's watched views is drawn to its end. If thirty views that open at once took turns,
    // all of them would stay empty for long.
    let waits_from =
        |task: &QueuedPicture| if urgency == Urgency::Watched { task.queued_at } else { task.last_turn_at };
    let order = |a: &QueuedPicture, b: &QueuedPicture| {
        a.charged.order(&b.charged).then(waits_from(a).cmp(&waits_from(b)))
    };
    Some(of_it.min_by(|(_, a), (_, b)| order(a, b))?.0)
}

#[cfg(test)]
mod tests;

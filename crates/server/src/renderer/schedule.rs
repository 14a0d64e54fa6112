//! Choice of the picture that is drawn next, and of the length of its slice of drawing time (a turn in names). Knows no
//! device and no clock.
//!
//! Among equally urgent pictures the one of the least charged client is next (`crate::charges`). Of several pictures of
//! that client, the one that has waited longest is next. Views that a user moves come first. While a user moves a view,
//! the views of clients that only watch get a share of the time. While anything moves at all, views at rest and stills
//! get a share too. The schedule adds up the unused share of each class as owed time. Once a class is owed a whole
//! slice, it gets a slice before more urgent pictures do. Likewise views at rest come before stills, which get a share
//! while views at rest wait. A class has no limit while nothing more urgent is drawn.

use std::time::{Duration, Instant};

use crate::charges::ChargedSeconds;
use crate::limits::{MAX_TURN, MOVING_FOR, MOVING_TURN, SETTLING_TIME_SHARE, TURN_WHILE_MOVING, WATCHED_TIME_SHARE};

/// Urgency of a picture. More urgent pictures are drawn first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// A view in which its viewer moves something.
    Moving,
    /// A view in which another user moves something.
    Watched,
    /// A view at rest.
    Settling,
    /// Picture for an HTTP request. Nobody sees it unfinished.
    Still,
}

impl Urgency {
    /// All urgencies, the most urgent first.
    pub const ALL: [Self; 4] = [Self::Moving, Self::Watched, Self::Settling, Self::Still];

    /// Returns the name in `/metrics`.
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

/// Picture in the queue of the render thread.
#[derive(Clone, Copy, Debug)]
pub struct QueuedPicture {
    pub urgency: Urgency,
    /// Seconds of drawing that the picture's client has been charged so far.
    pub charged: ChargedSeconds,
    /// End of the picture's latest slice of drawing time, or the time at which it was queued.
    pub last_turn_at: Instant,
    /// Time at which the picture was queued, with or without slices of drawing time since.
    pub queued_at: Instant,
}

/// Next action of the render thread.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScheduledTurn {
    /// Draw the waiting picture with this index for about this time.
    Draw(usize, Duration),
    /// Draw nothing until this time has passed or a new picture arrives.
    Wait(Duration),
    Idle,
}

/// Urgencies whose drawing time is limited while something more urgent is drawn, the most urgent first, each with its
/// share of the time.
const SHARES: [(Urgency, f64); 3] = [
    (Urgency::Watched, WATCHED_TIME_SHARE),
    (Urgency::Settling, SETTLING_TIME_SHARE),
    (Urgency::Still, SETTLING_TIME_SHARE),
];

/// A value for each class of `SHARES`.
type PerClass<T> = [T; SHARES.len()];

/// State of the schedule between two slices of drawing time.
#[derive(Clone, Debug, Default)]
pub struct Schedule {
    /// Time at which a picture of a view that its own viewer moves last waited or was drawn. The next field is the same
    /// for any moving view.
    last_interactive: Option<Instant>,
    last_moving: Option<Instant>,
    /// Seconds of drawing time owed to each class of `SHARES`: watched views, views at rest and stills. Negative if
    /// the class had more than its share.
    owed_seconds: PerClass<f64>,
    /// Time up to which shares are added to `owed_seconds`.
    accrued_until: Option<Instant>,
    /// Class that got the current slice. The slice is deducted from what this class is owed, even if a picture of
    /// another class is drawn in it.
    turn_class: Option<Urgency>,
}

impl Schedule {
    /// Chooses the picture to draw next and the length of its slice.
    pub fn next(&mut self, now: Instant, waiting: &[QueuedPicture]) -> ScheduledTurn {
        let waits = |urgency| waiting.iter().any(|task| task.urgency == urgency);
        if waits(Urgency::Moving) {
            self.last_interactive = Some(now);
        }
        if waits(Urgency::Moving) || waits(Urgency::Watched) {
            self.last_moving = Some(now);
        }
        let lately =
            |moved: Option<Instant>| moved.is_some_and(|moved| now.saturating_duration_since(moved) < MOVING_FOR);
        let (is_interactive, moves) = (lately(self.last_interactive), lately(self.last_moving));
        let limited = [is_interactive, moves, moves || waits(Urgency::Settling)];
        let turn = if moves { TURN_WHILE_MOVING } else { MAX_TURN };
        self.accrue_shares(now, SHARES.map(|(urgency, _)| waits(urgency)), limited, turn);

        let turn = self.choose(waiting, limited, turn);
        self.turn_class = if let ScheduledTurn::Draw(index, _) = turn { Some(waiting[index].urgency) } else { None };
        turn
    }

    /// Chooses the next slice, if the marked classes of `SHARES` are limited to their shares.
    fn choose(&self, waiting: &[QueuedPicture], limited: PerClass<bool>, turn: Duration) -> ScheduledTurn {
        // Owed slices come first, starting with the least urgent class.
        for (index, (urgency, _)) in SHARES.iter().enumerate().rev() {
            if limited[index]
                && self.owed_seconds[index] >= turn.as_secs_f64()
                && let Some(first) = least_charged(waiting, *urgency)
            {
                return ScheduledTurn::Draw(first, turn);
            }
        }
        if let Some(first) = least_charged(waiting, Urgency::Moving) {
            return ScheduledTurn::Draw(first, MOVING_TURN);
        }
        let mut unlimited = SHARES.iter().zip(limited).filter(|(_, limited)| !limited).map(|(share, _)| share.0);
        if let Some(first) = unlimited.find_map(|urgency| least_charged(waiting, urgency)) {
            return ScheduledTurn::Draw(first, turn);
        }
        if waiting.is_empty() {
            return ScheduledTurn::Idle;
        }
        let waits_for = waiting.iter().filter_map(|task| account_index(task.urgency));
        let missing = waits_for.map(|index| (turn.as_secs_f64() - self.owed_seconds[index]).max(0.0) / SHARES[index].1);
        let least = missing.fold(f64::INFINITY, f64::min);
        ScheduledTurn::Wait(Duration::from_secs_f64(least).clamp(Duration::from_millis(1), MOVING_FOR))
    }

    /// Notes a slice that was used from `began` to `ended` for a picture of `urgency`. The class that the slice was
    /// given to may be another one, because the thread of a scene first finishes the picture that it has begun.
    pub fn record_turn(&mut self, urgency: Urgency, [began, ended]: [Instant; 2]) {
        if urgency == Urgency::Moving {
            self.last_interactive = Some(ended);
        }
        if urgency.is_moving() {
            self.last_moving = Some(ended);
        }
        if let Some(index) = self.turn_class.take().and_then(account_index) {
            self.owed_seconds[index] -= ended.saturating_duration_since(began).as_secs_f64();
        }
    }

    /// Adds each class's share of the time since the last call to the seconds owed to it. A class is owed at most one
    /// slice, so it cannot save up time.
    fn accrue_shares(&mut self, now: Instant, waits: PerClass<bool>, limited: PerClass<bool>, turn: Duration) {
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

/// Returns the index of a class in `SHARES`. `None` for views that a user moves, whose time is not limited.
fn account_index(urgency: Urgency) -> Option<usize> {
    SHARES.iter().position(|(class, _)| *class == urgency)
}

fn least_charged(waiting: &[QueuedPicture], urgency: Urgency) -> Option<usize> {
    let of_it = waiting.iter().enumerate().filter(|(_, task)| task.urgency == urgency);
    // The oldest picture of a client's watched views is drawn to its end. If thirty views that open at once alternated,
    // all of them would stay empty for long.
    let waits_from =
        |task: &QueuedPicture| if urgency == Urgency::Watched { task.queued_at } else { task.last_turn_at };
    let order =
        |a: &QueuedPicture, b: &QueuedPicture| a.charged.order(&b.charged).then(waits_from(a).cmp(&waits_from(b)));
    Some(of_it.min_by(|(_, a), (_, b)| order(a, b))?.0)
}

#[cfg(test)]
mod tests;

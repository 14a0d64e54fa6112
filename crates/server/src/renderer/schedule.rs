//! Who draws next, and for how long. Knows no device and no clock.
//!
//! What moves comes first. While something moves, pictures of views at rest get a share of the time, and so do
//! stills: what they have not used they are owed, and once that is enough for a turn they get it, though something
//! moving waits. Views at rest go before stills in the same way. Where nothing more urgent goes on, there are no
//! shares.

use std::time::{Duration, Instant};

use crate::limits::{MOVING_FOR, REST_SHARE, TURN_AT_LEAST, TURN_AT_MOST};

/// What is more urgent is drawn first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Urgency {
    /// A view in which something moves.
    Moving,
    /// A view at rest.
    Settling,
    /// Nobody sees it grow.
    Still,
}

/// A picture that waits.
#[derive(Clone, Copy, Debug)]
pub struct Waiting {
    /// How urgent it is.
    pub urgency: Urgency,
    /// When it was last worked on, or when it came.
    pub touched: Instant,
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

/// What it remembers from turn to turn.
#[derive(Clone, Debug)]
pub struct Schedule {
    /// When something last moved.
    moved: Option<Instant>,
    /// What a moving picture takes, lately.
    moving_takes: Duration,
    /// Seconds that views at rest and stills are owed; below zero they have had more than their share.
    owed: [f64; 2],
    /// Until when that was reckoned.
    reckoned: Option<Instant>,
}

impl Schedule {
    /// Nothing has been drawn.
    pub fn new() -> Self {
        Self { moved: None, moving_takes: TURN_AT_MOST, owed: [0.0; 2], reckoned: None }
    }

    /// Whose turn it is.
    pub fn next(&mut self, now: Instant, waiting: &[Waiting]) -> Turn {
        let waits = |urgency| waiting.iter().any(|task| task.urgency == urgency);
        if waits(Urgency::Moving) {
            self.moved = Some(now);
        }
        let moves = self.moved.is_some_and(|moved| now.saturating_duration_since(moved) < MOVING_FOR);
        let settles = waits(Urgency::Settling);
        let limited = [moves, moves || settles];
        let turn = self.turn(moves);
        self.reckon(now, [settles, waits(Urgency::Still)], limited, turn);

        // What is owed longest first, though it is the least urgent.
        for urgency in [Urgency::Still, Urgency::Settling] {
            let index = account(urgency);
            if limited[index]
                && self.owed[index] >= turn.as_secs_f64()
                && let Some(first) = longest_untouched(waiting, urgency)
            {
                return Turn::Draw(first, turn);
            }
        }
        for urgency in [Urgency::Moving, Urgency::Settling, Urgency::Still] {
            let free = urgency == Urgency::Moving || !limited[account(urgency)];
            if free && let Some(first) = longest_untouched(waiting, urgency) {
                return Turn::Draw(first, turn);
            }
        }
        if waiting.is_empty() {
            return Turn::Idle;
        }
        let missing = waiting.iter().map(|task| turn.as_secs_f64() - self.owed[account(task.urgency)]);
        let least = missing.fold(f64::INFINITY, f64::min).max(0.0) / REST_SHARE;
        Turn::Wait(Duration::from_secs_f64(least).clamp(Duration::from_millis(1), MOVING_FOR))
    }

    /// A turn is over; it went on from `began` to `ended`.
    pub fn note(&mut self, urgency: Urgency, began: Instant, ended: Instant) {
        let took = ended.saturating_duration_since(began);
        if urgency == Urgency::Moving {
            self.moved = Some(ended);
            self.moving_takes = (3 * self.moving_takes + took) / 4;
        } else {
            self.owed[account(urgency)] -= took.as_secs_f64();
        }
    }

    /// How long a turn should be: while something moves, half of what that takes, so that it hardly stumbles.
    fn turn(&self, moves: bool) -> Duration {
        let turn = if moves { self.moving_takes / 2 } else { TURN_AT_MOST };
        turn.clamp(TURN_AT_LEAST, TURN_AT_MOST)
    }

    /// Adds the share of the time since the last reckoning, at most to what one turn takes: nobody saves up.
    fn reckon(&mut self, now: Instant, waits: [bool; 2], limited: [bool; 2], turn: Duration) {
        let since = self.reckoned.map_or(Duration::ZERO, |then| now.saturating_duration_since(then));
        self.reckoned = Some(now);
        for (index, owed) in self.owed.iter_mut().enumerate() {
            *owed = match (limited[index], waits[index]) {
                (true, true) => (*owed + REST_SHARE * since.as_secs_f64()).min(turn.as_secs_f64()),
                // Debts are paid off also while nobody waits.
                (true, false) => (*owed + REST_SHARE * since.as_secs_f64()).min(0.0),
                (false, _) => 0.0,
            };
        }
    }
}

/// Where the account of a class that has one stands.
fn account(urgency: Urgency) -> usize {
    usize::from(urgency == Urgency::Still)
}

fn longest_untouched(waiting: &[Waiting], urgency: Urgency) -> Option<usize> {
    let of_it = waiting.iter().enumerate().filter(|(_, task)| task.urgency == urgency);
    Some(of_it.min_by_key(|(_, task)| task.touched)?.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What came of an afternoon of drawing.
    #[derive(Debug, Default)]
    struct Outcome {
        /// Between the ends of two moving pictures.
        gaps: Vec<Duration>,
        /// Time that each still had.
        stills: Vec<Duration>,
        settles: Duration,
        total: Duration,
    }

    /// A turn that is over: whose, from when to when.
    type Over = Option<(Urgency, Instant, Instant)>;
    type Choose<'a> = &'a mut dyn FnMut(Instant, &[Waiting], Over) -> Turn;

    /// Plays `seconds` in which `viewers` drag, each asking for the next picture `pause` after the last, beside
    /// stills and views at rest that never end. A moving picture takes `moving`; a turn of the others what they are
    /// told to take or `piece`, if that is longer.
    fn play(
        choose: Choose,
        (viewers, moving, pause): (usize, Duration, Duration),
        (stills, settles, piece): (usize, usize, Duration),
        seconds: u64,
    ) -> Outcome {
        let start = Instant::now();
        let mut now = start;
        let mut asks: Vec<Instant> = vec![start; viewers];
        let mut shown: Vec<Instant> = vec![start; viewers];
        let mut rest: Vec<Waiting> = [(Urgency::Still, stills), (Urgency::Settling, settles)]
            .into_iter()
            .flat_map(|(urgency, count)| std::iter::repeat_n(Waiting { urgency, touched: start }, count))
            .collect();
        let mut outcome = Outcome { stills: vec![Duration::ZERO; stills], ..Outcome::default() };
        let mut last = None;
        while now < start + Duration::from_secs(seconds) {
            let asking: Vec<usize> = (0..viewers).filter(|&viewer| asks[viewer] <= now).collect();
            let moving_tasks = asking.iter().map(|&v| Waiting { urgency: Urgency::Moving, touched: asks[v] });
            let waiting: Vec<Waiting> = moving_tasks.chain(rest.iter().copied()).collect();
            let soonest = asks.iter().min().copied();
            let began = now;
            match choose(now, &waiting, last.take()) {
                Turn::Draw(index, _) if index < asking.len() => {
                    now += moving;
                    let viewer = asking[index];
                    outcome.gaps.push(now - shown[viewer]);
                    (asks[viewer], shown[viewer]) = (now + pause, now);
                    last = Some((Urgency::Moving, began, now));
                }
                Turn::Draw(index, turn) => {
                    let index = index - asking.len();
                    now += turn.max(piece);
                    rest[index].touched = now;
                    match rest[index].urgency {
                        Urgency::Still => outcome.stills[index] += now - began,
                        _ => outcome.settles += now - began,
                    }
                    last = Some((rest[index].urgency, began, now));
                }
                Turn::Wait(time) => {
                    let until =
                        soonest.filter(|ask| *ask > now).map_or(now + time, |ask| ask.min(now + time));
                    now = until;
                }
                Turn::Idle => now = soonest.expect("somebody drags").max(now + Duration::from_micros(1)),
            }
        }
        outcome.total = now - start;
        outcome
    }

    fn by_schedule() -> impl FnMut(Instant, &[Waiting], Over) -> Turn {
        let mut schedule = Schedule::new();
        move |now, waiting, last| {
            if let Some((urgency, began, ended)) = last {
                schedule.note(urgency, began, ended);
            }
            schedule.next(now, waiting)
        }
    }

    const MS: fn(u64) -> Duration = Duration::from_millis;

    /// Whether a drag beside other work kept its pace, and the others theirs.
    fn fair(choose: Choose, drag: (usize, Duration, Duration), piece: Duration) -> Result<(), String> {
        let seconds = 60;
        let stills = 8;
        let outcome = play(choose, drag, (stills, 0, piece), seconds);
        let (viewers, moving, pause) = drag;
        // Alone, a viewer waits for the others' pictures or for its own pause.
        let usual = (moving * viewers as u32).max(moving + pause);
        let alone = seconds as f64 / usual.as_secs_f64() * viewers as f64;
        let rate = outcome.gaps.len() as f64 / alone;
        let longest = outcome.gaps.iter().max().copied().unwrap_or(Duration::MAX);
        if rate < 0.85 {
            return Err(format!("{:.0} % of the pictures", 100.0 * rate));
        }
        // A turn or the share of that time, whichever is longer; a piece of work can be longer than a turn.
        let turn = piece.max(moving / 2).max(TURN_AT_LEAST);
        if longest > usual + turn + usual.mul_f64(REST_SHARE) + MS(2) {
            return Err(format!("a gap of {longest:?} where {usual:?} is usual"));
        }
        let had: Duration = outcome.stills.iter().sum();
        let share = had.as_secs_f64() / outcome.total.as_secs_f64();
        if !(0.5 * REST_SHARE..=1.1 * REST_SHARE).contains(&share) {
            return Err(format!("a share of {share:.3}"));
        }
        let (least, most) = (outcome.stills.iter().min(), outcome.stills.iter().max());
        if least.zip(most).is_none_or(|(least, most)| *least * 3 < *most) {
            return Err(format!("shares between stills of {least:?} to {most:?}"));
        }
        Ok(())
    }

    const DRAGS: [(usize, u64, u64); 5] = [(1, 150, 15), (1, 3, 13), (1, 30, 100), (3, 80, 15), (8, 10, 5)];

    #[test]
    fn a_drag_keeps_its_pace_beside_stills() {
        for (viewers, moving, pause) in DRAGS {
            for piece in [1, 20, 40] {
                let drag = (viewers, MS(moving), MS(pause));
                assert_eq!(fair(&mut by_schedule(), drag, MS(piece)), Ok(()), "{drag:?} {piece}");
            }
        }
    }

    /// The planted faults: a still that waited for half a second gets a whole sample; stills that wait for ever;
    /// stills in every pause.
    #[test]
    fn faults_are_seen() {
        let drag = (1, MS(150), MS(15));
        let first = |waiting: &[Waiting], urgency| longest_untouched(waiting, urgency);
        let mut patience = |now: Instant, waiting: &[Waiting], _: Over| {
            let left = waiting.iter().position(|task| now - task.touched >= MS(500));
            let next = left.or(first(waiting, Urgency::Moving)).or(first(waiting, Urgency::Still));
            next.map_or(Turn::Idle, |index| Turn::Draw(index, MS(8_000)))
        };
        assert!(fair(&mut patience, drag, MS(20)).is_err());
        let mut starve = |_: Instant, waiting: &[Waiting], _: Over| {
            first(waiting, Urgency::Moving).map_or(Turn::Wait(MS(1)), |index| Turn::Draw(index, MS(50)))
        };
        assert!(fair(&mut starve, drag, MS(20)).is_err());
        let mut greedy = |_: Instant, waiting: &[Waiting], _: Over| {
            let next = first(waiting, Urgency::Moving).or(first(waiting, Urgency::Still));
            next.map_or(Turn::Idle, |index| Turn::Draw(index, MS(50)))
        };
        assert!(fair(&mut greedy, drag, MS(20)).is_err());
    }

    #[test]
    fn at_rest_nothing_is_held_back() {
        let outcome = play(&mut by_schedule(), (0, MS(1), MS(1)), (3, 0, MS(1)), 10);
        assert_eq!(outcome.stills.iter().sum::<Duration>(), outcome.total);
        // Views at rest go before stills, which still get on.
        let outcome = play(&mut by_schedule(), (0, MS(1), MS(1)), (3, 1, MS(1)), 10);
        let stills = outcome.stills.iter().sum::<Duration>().as_secs_f64() / outcome.total.as_secs_f64();
        assert!((0.5 * REST_SHARE..=1.1 * REST_SHARE).contains(&stills), "{stills}");
        assert!(outcome.settles > outcome.total * 8 / 10);
    }
}

//! Simulated drags beside other work.

mod clients;

use super::*;
use crate::charges::{Charges, Payer};

/// Result of a simulation.
#[derive(Debug, Default)]
struct PlayedDrag {
    /// Times from the moment when one picture of an interactive view is drawn until the next one is, of all such views.
    gaps: Vec<Duration>,
    /// The same times of each watching view.
    watched: Vec<Vec<Duration>>,
    /// Drawing time of each still.
    stills: Vec<Duration>,
    settles: Duration,
    total: Duration,
}

impl PlayedDrag {
    fn longest_gap(&self) -> Duration {
        self.gaps.iter().max().copied().unwrap_or(Duration::MAX)
    }

    /// Returns the share of the time that stills had.
    fn still_share(&self) -> f64 {
        self.stills.iter().sum::<Duration>().as_secs_f64() / self.total.as_secs_f64()
    }
}

/// True if a share of the time is about that of the least urgent class.
fn is_settling_share(share: f64) -> bool {
    (0.5 * SETTLING_TIME_SHARE..=1.1 * SETTLING_TIME_SHARE).contains(&share)
}

/// Returns a waiting picture. All are of one client.
fn waits(urgency: Urgency, queued_at: Instant) -> QueuedPicture {
    let charged = Charges::default().of(&Payer::program("shot"));
    QueuedPicture { urgency, charged, last_turn_at: queued_at, queued_at }
}

/// Returns the number of slices until the first of `views` pictures of `urgency` is drawn. All are of one client and
/// take ten slices each.
fn turns_until_one_is_drawn(urgency: Urgency, views: u64) -> usize {
    let start = Instant::now();
    let mut left: Vec<(QueuedPicture, u32)> =
        (0..views).map(|n| (waits(urgency, start + Duration::from_millis(n)), 10)).collect();
    let mut schedule = Schedule::default();
    let mut now = start + Duration::from_secs(1);
    let mut turns = 0;
    while left.iter().all(|(_, turns)| *turns > 0) {
        let waiting: Vec<QueuedPicture> = left.iter().map(|(waiting, _)| *waiting).collect();
        let began = now;
        now += TURN_WHILE_MOVING;
        let ScheduledTurn::Draw(index, _) = schedule.next(began, &waiting) else { continue };
        schedule.record_turn(urgency, [began, now]);
        left[index].0.last_turn_at = now;
        left[index].1 -= 1;
        turns += 1;
    }
    turns
}

/// Deliberate fault that the simulation must show: each picture at rest gets a slice before any gets two.
#[test]
fn the_oldest_watched_picture_is_finished_first() {
    assert_eq!(turns_until_one_is_drawn(Urgency::Watched, 30), 10);
    assert_eq!(turns_until_one_is_drawn(Urgency::Settling, 30), 30 * 9 + 1);
}

/// Finished slice of drawing time: class of its picture, start and end.
type Over = Option<(Urgency, Instant, Instant)>;
type Choose<'a> = &'a mut dyn FnMut(Instant, &[QueuedPicture], Over) -> ScheduledTurn;

/// A drag: number of interactive and watching views, drawing time of a picture, and pause of each view before its next
/// one.
#[derive(Clone, Copy, Debug)]
struct SimulatedDrag {
    interactive_views: usize,
    watchers: usize,
    moving: Duration,
    pause: Duration,
}

/// Endless stills and views at rest beside a drag. A slice of one takes the given time, or `piece` if that is longer.
#[derive(Clone, Copy, Debug, Default)]
struct OtherWork {
    stills: usize,
    settles: usize,
    piece: Duration,
}

/// Simulates `seconds` of a drag beside other work.
fn play(choose: Choose, drag: SimulatedDrag, other: OtherWork, seconds: u64) -> PlayedDrag {
    let SimulatedDrag { interactive_views, watchers, moving, pause } = drag;
    let OtherWork { stills, settles, piece } = other;
    let start = Instant::now();
    let mut now = start;
    let viewers = interactive_views + watchers;
    let mut asks: Vec<Instant> = vec![start; viewers];
    let mut last_end: Vec<Instant> = vec![start; viewers];
    let urgency_of = |viewer| if viewer < interactive_views { Urgency::Moving } else { Urgency::Watched };
    let mut rest: Vec<QueuedPicture> = [(Urgency::Still, stills), (Urgency::Settling, settles)]
        .into_iter()
        .flat_map(|(urgency, count)| std::iter::repeat_n(waits(urgency, start), count))
        .collect();
    let (stills, watched) = (vec![Duration::ZERO; stills], vec![Vec::new(); watchers]);
    let mut outcome = PlayedDrag { watched, stills, ..PlayedDrag::default() };
    let mut last = None;
    while now < start + Duration::from_secs(seconds) {
        let asking: Vec<usize> = (0..viewers).filter(|&viewer| asks[viewer] <= now).collect();
        let moving_tasks = asking.iter().map(|&v| waits(urgency_of(v), asks[v]));
        let waiting: Vec<QueuedPicture> = moving_tasks.chain(rest.iter().copied()).collect();
        let soonest = asks.iter().copied().filter(|ask| *ask > now).min();
        let began = now;
        match choose(now, &waiting, last.take()) {
            ScheduledTurn::Draw(index, _) if index < asking.len() => {
                now += moving;
                let viewer = asking[index];
                let gaps = match viewer.checked_sub(interactive_views) {
                    None => &mut outcome.gaps,
                    Some(watcher) => &mut outcome.watched[watcher],
                };
                gaps.push(now - last_end[viewer]);
                (asks[viewer], last_end[viewer]) = (now + pause, now);
                last = Some((urgency_of(viewer), began, now));
            }
            ScheduledTurn::Draw(index, turn) => {
                let index = index - asking.len();
                now += turn.max(piece);
                rest[index].last_turn_at = now;
                match rest[index].urgency {
                    Urgency::Still => outcome.stills[index] += now - began,
                    _ => outcome.settles += now - began,
                }
                last = Some((rest[index].urgency, began, now));
            }
            ScheduledTurn::Wait(time) => now = soonest.map_or(now + time, |ask| ask.min(now + time)),
            ScheduledTurn::Idle => now = soonest.expect("somebody drags").max(now + Duration::from_micros(1)),
        }
    }
    outcome.total = now - start;
    outcome
}

fn by_schedule() -> impl FnMut(Instant, &[QueuedPicture], Over) -> ScheduledTurn {
    let mut schedule = Schedule::default();
    move |now, waiting, last| {
        if let Some((urgency, began, ended)) = last {
            schedule.record_turn(urgency, [began, ended]);
        }
        schedule.next(now, waiting)
    }
}

const MS: fn(u64) -> Duration = Duration::from_millis;

/// Checks that a drag beside other work keeps its frame rate, and that the other work gets its share.
fn fair(choose: Choose, drag: SimulatedDrag, piece: Duration) -> Result<(), String> {
    let seconds = 60;
    let outcome = play(choose, drag, OtherWork { stills: 8, settles: 0, piece }, seconds);
    let SimulatedDrag { interactive_views, moving, pause, .. } = drag;
    // Without other work a viewer waits for the other views' pictures, or for its own pause.
    let usual = (moving * interactive_views as u32).max(moving + pause);
    let alone = seconds as f64 / usual.as_secs_f64() * interactive_views as f64;
    let rate = outcome.gaps.len() as f64 / alone;
    let longest = outcome.longest_gap();
    if rate < 0.85 {
        return Err(format!("{:.0} % of the pictures", 100.0 * rate));
    }
    // A piece of work can be longer than a slice.
    let turn = piece.max(TURN_WHILE_MOVING);
    if longest > usual + turn + usual.mul_f64(SETTLING_TIME_SHARE) + MS(2) {
        return Err(format!("a gap of {longest:?} where {usual:?} is usual"));
    }
    let share = outcome.still_share();
    if !is_settling_share(share) {
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
            let drag = SimulatedDrag { interactive_views: viewers, watchers: 0, moving: MS(moving), pause: MS(pause) };
            assert_eq!(fair(&mut by_schedule(), drag, MS(piece)), Ok(()), "{drag:?} {piece}");
        }
    }
}

/// Deliberate faults that the checks must detect: a still that waited for half a second gets a whole sample; stills
/// wait forever; stills are drawn in every pause.
#[test]
fn faults_are_seen() {
    let drag = SimulatedDrag { interactive_views: 1, watchers: 0, moving: MS(150), pause: MS(15) };
    let mut patience = |now: Instant, waiting: &[QueuedPicture], _: Over| {
        let left = waiting.iter().position(|task| now - task.last_turn_at >= MS(500));
        let next = left.or(least_charged(waiting, Urgency::Moving)).or(least_charged(waiting, Urgency::Still));
        next.map_or(ScheduledTurn::Idle, |index| ScheduledTurn::Draw(index, MS(8_000)))
    };
    assert!(fair(&mut patience, drag, MS(20)).is_err());
    let mut starve = |_: Instant, waiting: &[QueuedPicture], _: Over| {
        least_charged(waiting, Urgency::Moving)
            .map_or(ScheduledTurn::Wait(MS(1)), |index| ScheduledTurn::Draw(index, MS(50)))
    };
    assert!(fair(&mut starve, drag, MS(20)).is_err());
    let mut greedy = |_: Instant, waiting: &[QueuedPicture], _: Over| {
        let next = least_charged(waiting, Urgency::Moving).or(least_charged(waiting, Urgency::Still));
        next.map_or(ScheduledTurn::Idle, |index| ScheduledTurn::Draw(index, MS(50)))
    };
    assert!(fair(&mut greedy, drag, MS(20)).is_err());
}

#[test]
fn without_interaction_nothing_is_throttled() {
    let nobody = SimulatedDrag { interactive_views: 0, watchers: 0, moving: MS(1), pause: MS(1) };
    let stills = OtherWork { stills: 3, settles: 0, piece: MS(1) };
    let outcome = play(&mut by_schedule(), nobody, stills, 10);
    assert_eq!(outcome.stills.iter().sum::<Duration>(), outcome.total);
    // Views at rest precede stills, which still progress.
    let outcome = play(&mut by_schedule(), nobody, OtherWork { settles: 1, ..stills }, 10);
    assert!(is_settling_share(outcome.still_share()), "{}", outcome.still_share());
    assert!(outcome.settles > outcome.total * 8 / 10);
}

/// Checks that pictures of interactive views precede those of watching views, which still get drawn.
fn interactive_first(choose: Choose, drag: SimulatedDrag) -> Result<(), String> {
    let seconds = 60;
    let outcome = play(choose, drag, OtherWork::default(), seconds);
    let SimulatedDrag { watchers, moving, pause, .. } = drag;
    // Watching views take at most their share of the time that an interactive view has alone.
    let alone = seconds as f64 / (moving + pause).as_secs_f64();
    let rate = outcome.gaps.len() as f64 / alone;
    if rate < 0.9 * (1.0 - WATCHED_TIME_SHARE) {
        return Err(format!("{:.0} % of the interactive view's pictures", 100.0 * rate));
    }
    // Never two watched pictures between two interactive ones, if the pause is shorter than a picture.
    let longest = outcome.longest_gap();
    if pause < moving && longest > moving + pause + moving + MS(2) {
        return Err(format!("a gap of {longest:?} where {:?} is usual", moving + pause));
    }
    let counts: Vec<usize> = outcome.watched.iter().map(Vec::len).collect();
    let share = counts.iter().sum::<usize>() as f64 * moving.as_secs_f64() / outcome.total.as_secs_f64();
    let expected = (watchers as f64 * moving.as_secs_f64() / (moving + pause).as_secs_f64()).min(WATCHED_TIME_SHARE);
    // Credit of a class without requests expires, so a part of the share is lost in the watching views' pauses.
    if share < 0.5 * expected {
        return Err(format!("a share of {share:.3} for those who watch"));
    }
    if counts.iter().max() > counts.iter().min().map(|least| least + 2).as_ref() {
        return Err(format!("pictures of those who watch: {counts:?}"));
    }
    Ok(())
}

const WATCHED_DRAGS: [(usize, u64, u64); 5] = [(1, 100, 15), (3, 100, 15), (3, 30, 5), (8, 50, 10), (2, 5, 20)];

#[test]
fn interactive_views_come_first_and_watched_ones_do_not_starve() {
    for (watchers, moving, pause) in WATCHED_DRAGS {
        let drag = SimulatedDrag { interactive_views: 1, watchers, moving: MS(moving), pause: MS(pause) };
        assert_eq!(interactive_first(&mut by_schedule(), drag), Ok(()), "{drag:?}");
    }
    // Without interactive views the watching ones have all the time.
    let drag = SimulatedDrag { interactive_views: 0, watchers: 2, moving: MS(50), pause: MS(10) };
    let outcome = play(&mut by_schedule(), drag, OtherWork::default(), 10);
    assert!(outcome.watched.iter().all(|gaps| gaps.len() >= 99), "{outcome:?}");
}

/// Deliberate faults that the checks must detect: all views are drawn in rotation; watching views are drawn only while
/// the interactive view pauses.
#[test]
fn planted_unfair_schedules_are_caught() {
    let drag = SimulatedDrag { interactive_views: 1, watchers: 3, moving: MS(100), pause: MS(15) };
    let mut in_turn = |_: Instant, waiting: &[QueuedPicture], _: Over| {
        let first = waiting.iter().enumerate().min_by_key(|(_, task)| task.last_turn_at);
        first.map_or(ScheduledTurn::Idle, |(index, _)| ScheduledTurn::Draw(index, MS(50)))
    };
    assert!(interactive_first(&mut in_turn, drag).is_err());
    let mut schedule = by_schedule();
    let mut starve = |now: Instant, waiting: &[QueuedPicture], last: Over| match schedule(now, waiting, last) {
        ScheduledTurn::Draw(index, _) if waiting[index].urgency == Urgency::Watched => ScheduledTurn::Wait(MS(1)),
        turn => turn,
    };
    assert!(interactive_first(&mut starve, drag).is_err());
}

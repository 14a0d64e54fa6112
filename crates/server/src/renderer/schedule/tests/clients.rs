//! A client beside another one that draws as much as it can.

use super::*;

/// A client with that many moving views.
#[derive(Clone, Copy, Debug)]
struct Client {
    views: usize,
    /// Drawing time of a picture, and pause of each view before its next one.
    picture: Duration,
    pause: Duration,
}

/// Deliberate fault in the schedule, which the simulation must show; or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    None,
    /// No charges: the picture that has waited longest is next.
    NoCharge,
    /// A picture is drawn to its end.
    NoYield,
    /// Each picture costs the same, whatever its time.
    CostByPictureCount,
}

#[derive(Clone, Copy, Debug)]
struct View {
    client: usize,
    asks_at: Instant,
    /// Remaining drawing time of the current picture.
    left: Duration,
}

/// Ends of the first client's pictures in that many seconds beside the others.
fn play(clients: &[Client], seconds: u64, fault: Fault) -> Vec<Duration> {
    let (mut schedule, mut charges) = (Schedule::default(), Charges::default());
    let payers: Vec<Payer> =
        (0..clients.len()).map(|k| Payer::new(&format!("session {k}").into(), &k.to_string())).collect();
    let start = Instant::now();
    let views = clients.iter().enumerate().flat_map(|(client, of)| {
        let view = View { client, asks_at: start, left: of.picture };
        std::iter::repeat_n(view, of.views)
    });
    let (mut views, mut now, mut ended) = (views.collect::<Vec<View>>(), start, Vec::new());
    while now < start + Duration::from_secs(seconds) {
        let asking: Vec<usize> = (0..views.len()).filter(|&view| views[view].asks_at <= now).collect();
        let queued = |&view: &usize| {
            let charged = charges.of(&payers[views[view].client]);
            QueuedPicture { charged, ..waits(Urgency::Moving, views[view].asks_at) }
        };
        let waiting: Vec<QueuedPicture> = asking.iter().map(queued).collect();
        match schedule.next(now, &waiting) {
            ScheduledTurn::Draw(index, turn) => {
                let view = &mut views[asking[index]];
                let Client { picture, pause, .. } = clients[view.client];
                let takes = if fault == Fault::NoYield { view.left } else { view.left.min(turn) };
                let began = now;
                now += takes;
                view.left -= takes;
                let is_finished = view.left == Duration::ZERO;
                schedule.record_turn(Urgency::Moving, [began, now]);
                match fault {
                    Fault::NoCharge => {}
                    Fault::CostByPictureCount if !is_finished => {}
                    Fault::CostByPictureCount => charges.charge(&payers[view.client], 1.0),
                    Fault::None | Fault::NoYield => {
                        charges.charge(&payers[view.client], takes.as_secs_f64());
                    }
                }
                // A picture in progress stays requested until it is finished.
                view.asks_at = now;
                if is_finished {
                    (view.left, view.asks_at) = (picture, now + pause);
                    if view.client == 0 {
                        ended.push(now - start);
                    }
                }
            }
            ScheduledTurn::Wait(time) => now += time,
            ScheduledTurn::Idle => now = views.iter().map(|view| view.asks_at).min().expect("a view"),
        }
    }
    ended
}

/// Checks that a client gets at least 45 % of its pictures, and no gap over four times its usual one.
fn holds(victim: Client, other: Client, fault: Fault) -> Result<(), String> {
    let alone = play(&[victim], 20, Fault::None);
    let beside = play(&[victim, other], 20, fault);
    let share = beside.len() as f64 / alone.len() as f64;
    if share < 0.45 {
        return Err(format!("{:.0} % of its pictures", 100.0 * share));
    }
    let usual = victim.picture + victim.pause;
    let gaps = beside.windows(2).map(|pair| pair[1].saturating_sub(pair[0]));
    let longest = gaps.max().unwrap_or(Duration::MAX);
    if longest > 4 * usual { Err(format!("a gap of {longest:?}, {usual:?} is usual")) } else { Ok(()) }
}

const OTHERS: [(usize, u64); 4] = [(1, 1_000), (8, 400), (255, 40), (24, 5)];

#[test]
fn one_client_does_not_stop_another() {
    for (own, pause) in [(8, 12), (25, 15), (60, 15)] {
        let victim = Client { views: 1, picture: MS(own), pause: MS(pause) };
        for (views, picture) in OTHERS {
            let other = Client { views, picture: MS(picture), pause: MS(0) };
            assert_eq!(holds(victim, other, Fault::None), Ok(()), "{victim:?} beside {other:?}");
        }
    }
}

#[test]
fn planted_unfair_charging_is_caught() {
    let victim = Client { views: 1, picture: MS(25), pause: MS(15) };
    let beside = |fault| {
        let others = OTHERS.map(|(views, picture)| Client { views, picture: MS(picture), pause: MS(0) });
        others.iter().filter(|other| holds(victim, **other, fault).is_err()).count()
    };
    for fault in [Fault::NoCharge, Fault::NoYield, Fault::CostByPictureCount] {
        assert!(beside(fault) > 0, "{fault:?} is not seen");
    }
}

/// Returns the number of slices that a client's watched view gets before the interactive view of another client, which
/// has been charged less, gets its next slice. Each slice is spent on a moving picture that the scene's thread has in
/// progress.
fn turns_before_interactive_view(pays: impl Fn(&mut Schedule, [Instant; 2])) -> usize {
    let (mut schedule, mut charges) = (Schedule::default(), Charges::default());
    let [ada, bob] = ["ada", "bob"].map(|name| Payer::new(&name.into(), name));
    charges.charge(&bob, 0.01);
    let mut now = Instant::now();
    let mut turns = 0;
    // At first only the interactive view, until the watching one is owed a slice.
    for _ in 0..100 {
        let waiting = [(Urgency::Moving, &ada), (Urgency::Watched, &bob)]
            .map(|(urgency, payer)| QueuedPicture { charged: charges.of(payer), ..waits(urgency, now) });
        let ScheduledTurn::Draw(index, turn) = schedule.next(now, &waiting) else { panic!("somebody waits") };
        let began = now;
        now += turn;
        charges.charge([&ada, &bob][index], turn.as_secs_f64());
        match index {
            0 if turns > 0 => return turns,
            0 => schedule.record_turn(Urgency::Moving, [began, now]),
            _ => pays(&mut schedule, [began, now]),
        }
        turns += index;
    }
    turns
}

/// Deliberate fault that the test must detect: the time is deducted from the class of the drawn picture instead of the
/// class that got the slice. Then the watching view gets slice after slice.
#[test]
fn a_class_pays_for_its_turn_whatever_was_drawn() {
    assert_eq!(turns_before_interactive_view(|schedule, span| schedule.record_turn(Urgency::Moving, span)), 1);
    let unpaid = turns_before_interactive_view(|schedule, span| {
        schedule.turn_class = Some(Urgency::Moving);
        schedule.record_turn(Urgency::Moving, span);
    });
    assert!(unpaid > 50, "{unpaid}");
}

//! Simulated clients with good and bad links over planned changes, in steps of one millisecond. The tests read no
//! clock.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use stream::{FramePacer, FrameQuality, MAX_FRAMES_IN_FLIGHT, NextFrame, SETTLE_AFTER, ViewContent};

#[derive(Clone, Copy, Debug, PartialEq)]
struct Sent {
    at_ms: u64,
    revision: u64,
    quality: FrameQuality,
    key: bool,
    /// Time at which the acknowledgement arrives.
    acked_at_ms: Option<u64>,
}

/// A client and its link. Frame `k` is acknowledged after `delays_ms[k % len]`, never before an earlier one. A delay of
/// `None` means never.
struct Client {
    delays_ms: Vec<Option<u64>>,
    pace: FramePacer,
    wake: Option<Instant>,
    acks: VecDeque<(u64, u64)>,
    sent: Vec<Sent>,
}

impl Client {
    fn new(delays_ms: &[Option<u64>]) -> Self {
        let delays_ms = delays_ms.to_vec();
        Self { delays_ms, pace: FramePacer::default(), wake: None, acks: VecDeque::new(), sent: Vec::new() }
    }

    /// Delivers the acknowledgements that are due. Returns true if there were any.
    fn receive(&mut self, now_ms: u64, now: Instant) -> bool {
        let mut any = false;
        while self.acks.front().is_some_and(|(at_ms, _)| *at_ms <= now_ms) {
            let (_, frame) = self.acks.pop_front().expect("just seen");
            self.pace.acked(frame, now);
            any = true;
        }
        any
    }

    /// Sends the frames that the pacer requests.
    fn send(&mut self, content: ViewContent, now_ms: u64, now: Instant) {
        self.wake = None;
        loop {
            let quality = match self.pace.next(content, now) {
                NextFrame::Nothing => return,
                NextFrame::WaitUntil(time) => {
                    assert!(time > now, "a time that has come already would be asked for again and again");
                    self.wake = Some(time);
                    return;
                }
                NextFrame::Moving => FrameQuality::Moving,
                NextFrame::Settle => FrameQuality::Settled,
            };
            let key = self.pace.needs_key_frame();
            self.pace.sent(self.sent.len() as u64, content.revision, quality, now);
            let delay_ms = self.delays_ms[self.sent.len() % self.delays_ms.len()];
            let before_ms = self.acks.back().map_or(0, |(at_ms, _)| *at_ms);
            let acked_at_ms = delay_ms.map(|delay_ms| before_ms.max(now_ms + delay_ms));
            self.acks.extend(acked_at_ms.map(|at_ms| (at_ms, self.sent.len() as u64)));
            self.sent.push(Sent { at_ms: now_ms, revision: content.revision, quality, key, acked_at_ms });
        }
    }
}

/// Returns the frames of each client if the content changes at those times, until 20 seconds after the last one.
fn play(changes_ms: &[u64], links: &[&[Option<u64>]]) -> Vec<Vec<Sent>> {
    let start = Instant::now();
    let mut clients: Vec<_> = links.iter().map(|delays_ms| Client::new(delays_ms)).collect();
    let mut content = ViewContent { revision: 0, changed_at: start };
    let end_ms = changes_ms.last().unwrap_or(&0) + 20_000;
    for now_ms in 0..end_ms {
        let now = start + Duration::from_millis(now_ms);
        let changed = now_ms == 0 || changes_ms.contains(&now_ms);
        if changed {
            content = ViewContent { revision: content.revision + 1, changed_at: now };
        }
        for client in &mut clients {
            let received = client.receive(now_ms, now);
            if changed || received || client.wake.is_some_and(|time| time <= now) {
                client.send(content, now_ms, now);
            }
        }
    }
    clients.into_iter().map(|client| client.sent).collect()
}

/// Finds the faults in the frames of a client that acknowledges all of them.
fn faults(sent: &[Sent], changes_ms: &[u64]) -> Vec<&'static str> {
    let mut faults = Vec::new();
    let mut fault = |found: bool, what| faults.extend(found.then_some(what));
    let changes_ms: Vec<u64> = [0].into_iter().chain(changes_ms.iter().copied().filter(|at| *at > 0)).collect();
    let settle_ms = SETTLE_AFTER.as_millis() as u64;
    for (index, frame) in sent.iter().enumerate() {
        let under_way = sent[..=index].iter().filter(|f| f.acked_at_ms.is_none_or(|at| at > frame.at_ms)).count();
        fault(under_way > MAX_FRAMES_IN_FLIGHT, "more frames under way than the window holds");
        let last_change_ms = changes_ms.iter().rfind(|at| **at <= frame.at_ms).expect("0 is one");
        let is_settled = frame.quality == FrameQuality::Settled;
        fault(is_settled && frame.at_ms < last_change_ms + settle_ms, "settled while things moved");
        let revision = changes_ms.iter().filter(|at| **at <= frame.at_ms).count() as u64;
        fault(frame.revision != revision, "not the latest state");
        fault(frame.key != (index == 0), "a key frame for no reason, or none at the start");
        let again = sent[..index].iter().any(|f| (f.revision, f.quality) == (frame.revision, frame.quality));
        fault(again, "the same frame twice");
    }
    let last = sent.last().map(|frame| (frame.revision, frame.quality));
    fault(last != Some((changes_ms.len() as u64, FrameQuality::Settled)), "the last state did not arrive settled");
    faults
}

/// Generates sorted times of changes, in bursts and with pauses.
fn changes() -> impl Strategy<Value = Vec<u64>> {
    let gaps = proptest::collection::vec(prop_oneof![1..40_u64, 200..300_u64, 1..3000_u64], 0..40);
    gaps.prop_map(|gaps| {
        let mut at = 0;
        let times = gaps.into_iter().map(|gap| {
            at += gap;
            at
        });
        times.collect()
    })
}

/// Generates a link that acknowledges everything, even if late.
fn live_link() -> impl Strategy<Value = Vec<Option<u64>>> {
    proptest::collection::vec((0..2500_u64).prop_map(Some), 1..6)
}

fn any_link() -> impl Strategy<Value = Vec<Option<u64>>> {
    proptest::collection::vec(proptest::option::of(0..5000_u64), 1..6)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(128) })]

    /// FRAME-2, FRAME-3 and FRAME-4 on every link that acknowledges.
    #[test]
    fn a_live_client_ends_with_the_settled_state(changes_ms in changes(), link in live_link()) {
        let sent = &play(&changes_ms, &[&link])[0];
        prop_assert_eq!(faults(sent, &changes_ms), Vec::<&str>::new());

        // Deliberate fault that the check must detect: the last frame lost, one out of date, one too early, one too
        // many, a fourth in flight.
        let damaged = |damage: fn(&mut Vec<Sent>)| {
            let mut sent = sent.clone();
            damage(&mut sent);
            faults(&sent, &changes_ms)
        };
        prop_assert!(!damaged(|sent| sent.truncate(sent.len() - 1)).is_empty());
        prop_assert!(!damaged(|sent| sent[0].revision += 1).is_empty());
        let mut early = sent.clone();
        let settles_at_ms = changes_ms.last().unwrap_or(&0) + SETTLE_AFTER.as_millis() as u64;
        early.last_mut().expect("some").at_ms = settles_at_ms - 1;
        prop_assert!(!faults(&early, &changes_ms).is_empty());
        prop_assert!(!damaged(|sent| sent.push(sent[sent.len() - 1])).is_empty());
        let unacknowledged = damaged(|sent| sent.iter_mut().for_each(|frame| frame.acked_at_ms = None));
        prop_assert_eq!(unacknowledged.is_empty(), sent.len() <= MAX_FRAMES_IN_FLIGHT);
        let before_the_first_ack = sent.iter().filter(|frame| Some(frame.at_ms) < sent[0].acked_at_ms);
        prop_assert!(before_the_first_ack.count() <= 1);
    }

    /// FRAME-6: a bad link changes nothing for the other client. At rest the sending ends.
    #[test]
    fn links_do_not_touch_each_other(changes_ms in changes(), good in live_link(), bad in any_link()) {
        let both = play(&changes_ms, &[&bad, &good]);
        prop_assert_eq!(&both[1], &play(&changes_ms, &[&good])[0]);
        let rest_from_ms = changes_ms.last().unwrap_or(&0) + 12_000;
        prop_assert!(both[0].iter().all(|frame| frame.at_ms < rest_from_ms), "still sending at rest");
    }
}

/// FRAME-6: a client that acknowledges nothing gets no further frame.
#[test]
fn a_silent_client_gets_one_frame() {
    let changes_ms: Vec<u64> = (1..600).map(|k| 10 * k).collect();
    for changes_ms in [&[][..], &changes_ms] {
        let sent = &play(changes_ms, &[&[None]])[0];
        assert_eq!(sent.len(), 1, "{sent:?}");
        assert!(sent[0].key && sent[0].quality == FrameQuality::Moving);
    }
    // A client that stops acknowledging gets a full window.
    let sent = &play(&changes_ms, &[&[Some(5), None, None, None, None]])[0];
    let acked = sent.iter().take_while(|frame| frame.acked_at_ms.is_some()).count();
    assert_eq!(sent.len(), acked + MAX_FRAMES_IN_FLIGHT, "{sent:?}");
}

/// A client that resumes its acknowledgements is served again. One that starts anew gets a key frame.
#[test]
fn a_client_that_wakes_up_goes_on() {
    let start = Instant::now();
    let at = |ms| start + Duration::from_millis(ms);
    let mut pace = FramePacer::default();
    let content = |revision, ms| ViewContent { revision, changed_at: at(ms) };
    assert_eq!(pace.next(content(1, 1), at(1)), NextFrame::Moving);
    pace.sent(1, 1, FrameQuality::Moving, at(1));
    assert_eq!(pace.next(content(2, 2), at(2)), NextFrame::Nothing, "its first is not shown yet");
    assert_eq!(pace.acked(1, at(3)), Some(Duration::from_millis(2)));
    for frame in 2..=4 {
        assert_eq!(pace.next(content(frame, frame), at(frame)), NextFrame::Moving);
        pace.sent(frame, frame, FrameQuality::Moving, at(frame));
    }
    assert_eq!(pace.next(content(5, 5), at(60_000)), NextFrame::Nothing);
    assert_eq!(pace.acked(9, at(60_000)), None, "never sent");
    assert_eq!(pace.acked(3, at(60_001)), Some(Duration::from_millis(59_998)));
    assert_eq!((pace.free_slots(), pace.needs_key_frame()), (2, false));
    assert_eq!(pace.next(content(5, 5), at(60_001)), NextFrame::Moving);
    pace.start_anew();
    assert_eq!((pace.free_slots(), pace.needs_key_frame()), (MAX_FRAMES_IN_FLIGHT, true));
    assert_eq!(pace.acked(4, at(60_002)), None, "given up");
}

/// An acknowledgement counts for the earlier frames that the client skipped.
#[test]
fn a_client_may_pass_frames_over() {
    let now = Instant::now();
    let mut pace = FramePacer::default();
    pace.sent(0, 0, FrameQuality::Moving, now);
    assert_eq!(pace.acked(0, now), Some(Duration::ZERO));
    for frame in 1..=3 {
        pace.sent(frame, frame, FrameQuality::Moving, now);
    }
    assert_eq!(pace.acked(2, now), Some(Duration::ZERO));
    assert_eq!((pace.free_slots(), pace.acked(1, now)), (MAX_FRAMES_IN_FLIGHT - 1, None));
}

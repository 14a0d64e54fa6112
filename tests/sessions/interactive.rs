//! Order of pictures during a drag, the state that they show, and work in parallel to it.

use std::time::{Duration, Instant};

use bench::Incoming;
use light::parameters::EXPOSURE;
use protocol::Command;
use stream::FrameHeader;

use crate::sessions::support::{Mirror, Server, move_point, moved};

/// One update per animation frame.
const UPDATE_EVERY: Duration = Duration::from_micros(16_667);

/// Opens a view of its own of `size` pixels, and waits until it is at rest.
fn open(mirror: &mut Mirror, size: [u32; 2]) {
    mirror.open_view_of(size, None);
    mirror.settled_frame(0);
}

/// The first of `people` drags for `time`, with the updates of `command`. Returns the frames that each received
/// meanwhile.
fn drag(people: &mut [Mirror], time: Duration, mut command: impl FnMut(u64) -> Command) -> Vec<Vec<FrameHeader>> {
    people[0].begin("drag");
    let mut frames = vec![Vec::new(); people.len()];
    let (began, mut update) = (Instant::now(), 0);
    while began.elapsed() < time {
        if began.elapsed() >= UPDATE_EVERY * update as u32 {
            update += 1;
            people[0].update("drag", update, command(update));
        }
        for (person, frames) in people.iter_mut().zip(&mut frames) {
            if let Some(Incoming::Frame(header, _)) = person.client.receive(Duration::from_millis(1)).expect("received")
            {
                person.client.ack(&header).expect("sent");
                frames.push(header);
            }
        }
    }
    people[0].cancel("drag");
    frames
}

/// Goes from 0.5 to 0 and back; each update differs from the one before.
fn to_and_fro(update: u64) -> f64 {
    (((update % 60) as f64) / 60.0 - 0.5).abs()
}

fn median(values: impl Iterator<Item = u32>) -> u32 {
    let mut values: Vec<u32> = values.collect();
    values.sort_unstable();
    values[values.len() / 2]
}

/// One client drags, and three others watch in views of their own. The interactive client's frames come first, the
/// others' frames come too, and no render starts with an outdated state. (Before, all took turns and had equally many
/// frames, and a waiting render showed the state at the time it was queued, several pictures ago.)
///
/// Rules: FRAME-2, FRAME-11
#[test]
fn interactive_views_come_first_and_stale_pictures_are_not_begun() {
    let (_server, mut people) = Server::start_with(["ada", "ben", "cyd", "dan"]);
    for person in &mut people {
        open(person, [686, 382]);
    }
    let (light, point) = (people[0].light(), people[0].point(2));
    let shake = |update: u64| move_point(light, 2, moved(point, [0.0, to_and_fro(update), 0.0]));
    let frames = drag(&mut people, Duration::from_secs(6), shake);
    let counts: Vec<usize> = frames.iter().map(Vec::len).collect();
    let most = counts[1..].iter().max().expect("three watch");
    assert!(counts[0] >= 2 * most || counts[0] > 300, "{counts:?}: the hand's come first");
    assert!(counts[1..].iter().all(|count| *count >= 2), "{counts:?}: nobody is starved");
    // A render starts with the latest update. Its age is the render time of the interactive picture that was drawn
    // before, or the time to the next update, and at most as much again for other work of a busy machine. A state from
    // the time of queueing is older by a round, in which the interactive client has two pictures and each of the three
    // others one.
    let render_us = median(frames[0].iter().map(|header| header.render_us));
    let wait_us = median(frames[1..].iter().flatten().map(|header| header.wait_us));
    let most_us = 2 * render_us.max(UPDATE_EVERY.as_micros() as u32);
    assert!(wait_us < most_us, "{wait_us} us of waiting, {render_us} of drawing");
}

/// Rendering and encoding run in parallel: their total time is longer than the drag.
///
/// Rules: FRAME-2
#[test]
fn the_next_picture_is_drawn_while_one_is_encoded() {
    let (_server, mut people) = Server::start_with(["ada"]);
    open(&mut people[0], [1280, 720]);
    let light = people[0].light();
    let dim = |update: u64| Command::SetLight {
        light,
        parameter: EXPOSURE.to(to_and_fro(update)).into(),
        ignore_pins: false,
    };
    let time = Duration::from_secs(5);
    let frames = drag(&mut people, time, dim);
    let work = |header: &FrameHeader| Duration::from_micros(u64::from(header.render_us) + u64::from(header.encode_us));
    let worked: Duration = frames[0].iter().map(work).sum();
    // In sequence they could not take longer than the drag.
    assert!(worked > time, "{worked:?} of work in {time:?}, {} frames", frames[0].len());
    assert!(frames[0].is_sorted_by_key(|header| header.live_revision), "pictures stay in order");
}

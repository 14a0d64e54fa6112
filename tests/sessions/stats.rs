//! Statistics of frames, for clients that request them.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use bench::{Incoming, Tiles};
use light::parameters::INTENSITY;
use protocol::{
    Cause, ClientMessage, Command, FrameQuality, FrameStats, Pass, PassRun, ServerMessage, ViewSettings, ViewSource,
};
use stream::{FrameHeader, HEADER_BYTES};

use crate::sessions::support::{Mirror, Server, move_point, moved, oscillate, own_view, view_message};

/// Opens a view of 160 x 90 pixels, of its own or of the followed leader.
fn open(mirror: &mut Mirror, leader: Option<&Mirror>, stats: bool) {
    let own = || own_view(&mirror.client);
    let source = leader.map_or_else(own, |leader| ViewSource::Follow(leader.client.welcome.client));
    mirror.send(&view_message(source, [160, 90], None, stats));
}

/// Returns the next frame whose stats `accepts` takes. Each frame's stats come directly after it.
fn next_stats(mirror: &mut Mirror, mut accepts: impl FnMut(&FrameStats) -> bool) -> (FrameHeader, Tiles, FrameStats) {
    let mut latest: Option<(FrameHeader, Tiles)> = None;
    mirror.receive_until("stats", |incoming| match incoming {
        Incoming::Frame(header, tiles) => {
            assert!(latest.is_none(), "a frame without stats");
            latest = Some((*header, tiles.clone()));
            None
        }
        Incoming::Message(message) => match &**message {
            ServerMessage::Stats(stats) => {
                let (header, tiles) = latest.take().expect("stats come behind a frame");
                assert_eq!(stats.frame, header.frame);
                accepts(stats).then(|| (header, tiles, (**stats).clone()))
            }
            other => {
                assert!(latest.is_none(), "between a frame and its stats came {other:?}");
                None
            }
        },
    })
}

/// Passes that the next moving frame ran. Waits until all is at rest afterwards.
fn passes_run(mirror: &mut Mirror) -> Vec<(Pass, Option<u64>, Cause)> {
    let (.., stats) = next_stats(mirror, |stats| stats.quality == FrameQuality::Moving);
    let (.., at_rest) = next_stats(mirror, |stats| stats.quality == FrameQuality::Settled);
    let draws_map = |run: &PassRun| run.pass == Pass::ShadowMap;
    assert!(!at_rest.passes.iter().any(draws_map), "maps are kept: {at_rest:?}");
    stats.passes.iter().map(|run| (run.pass, run.light, run.cause)).collect()
}

/// Each edit names the passes that it needed, and no others. Lights have the document's ids.
///
/// Rules: FRAME-13
#[test]
fn stats_name_what_an_edit_had_drawn() {
    let (_server, [mut ada]) = Server::start_with(["ada"]);
    // An id that differs from the light's index among the lights.
    ada.edited(Command::AddCamera { camera: ada.client.welcome.camera.clone() });
    let (key, lamp) = (ada.light(), ada.add_lamp(30.0, 40.0));
    assert!(lamp > 2 && key < lamp);
    open(&mut ada, None, true);

    let (header, tiles, stats) = next_stats(&mut ada, |_| true);
    let first = |pass, light| PassRun { pass, light: Some(light), cause: Cause::First, runs: 1 };
    for light in [key, lamp] {
        assert!(stats.passes.contains(&first(Pass::ShadowMap, light)), "{stats:?}");
        assert!(stats.passes.contains(&first(Pass::Layer, light)), "{stats:?}");
    }
    let of_header = [header.wait_us, header.render_us, header.encode_us];
    assert_eq!([stats.wait_us, stats.render_us, stats.encode_us], of_header);
    let count = tiles.tiles().count();
    assert_eq!((stats.tiles as usize, stats.size, stats.shadow_map_divisor), (count, [160, 90], 1));
    assert_eq!(stats.bytes as usize, tiles.byte_count() + count * HEADER_BYTES);
    let (_, tiles, stats) = next_stats(&mut ada, |stats| stats.quality == FrameQuality::Settled);
    assert_eq!((stats.tiles as usize, stats.size), (tiles.tiles().count(), [160, 90]));
    assert!(stats.bytes as usize > tiles.byte_count());
    let gbuffers = stats.passes.iter().filter(|run| run.pass == Pass::Gbuffer);
    assert!(gbuffers.map(|run| run.runs).sum::<u32>() >= 4, "four samples: {stats:?}");

    let shown = (Pass::Display, None, Cause::NotKept);
    let of_light = |light| [(Pass::ShadowMap, Some(light), Cause::Light), (Pass::Layer, Some(light), Cause::Light)];
    ada.edit(move_point(key, 2, moved(ada.point(2), [0.0, 0.2, 0.0])));
    assert_eq!(passes_run(&mut ada), [&of_light(key)[..], &[shown]].concat());
    ada.edit(Command::PlaceLight {
        light: lamp,
        translation: Some([0.1, 3.0, 4.0]),
        rotation: None,
        scale: None,
        ignore_pins: false,
    });
    assert_eq!(passes_run(&mut ada), [&of_light(lamp)[..], &[shown]].concat());
    ada.edit(Command::SetLight { light: lamp, parameter: INTENSITY.to(10.0).into(), ignore_pins: false });
    let runs = passes_run(&mut ada);
    assert!(!runs.is_empty() && runs.iter().all(|run| matches!(run.0, Pass::Sum | Pass::Display)), "{runs:?}");
    ada.move_camera([0.1, 0.0, 0.0], 2);
    let runs = passes_run(&mut ada);
    assert!(runs.contains(&(Pass::Gbuffer, None, Cause::Camera)), "{runs:?}");
    assert!(!runs.iter().any(|run| run.0 == Pass::ShadowMap), "{runs:?}");
    let layer = |light| (Pass::Layer, Some(light), Cause::Gbuffer);
    assert!(runs.contains(&layer(key)) && runs.contains(&layer(lamp)), "{runs:?}");

    // The same picture again needs no drawing.
    ada.edit(Command::SetLight { light: lamp, parameter: INTENSITY.to(20.0).into(), ignore_pins: false });
    let (header, ..) = next_stats(&mut ada, |stats| stats.quality == FrameQuality::Settled);
    ada.send(&ClientMessage::RequestKeyFrame { frame: header.frame });
    let (again, _, stats) = next_stats(&mut ada, |_| true);
    assert_eq!((again.frame, again.flags.is_key, stats.passes), (header.frame + 1, true, Vec::new()));
}

/// Numbers of frames and of stats until all is at rest, and for half a second more.
fn counted(mirror: &mut Mirror) -> (u64, u64) {
    let (mut frames, mut stats) = (0, 0);
    let mut count = |incoming: &Incoming| match incoming {
        Incoming::Frame(header, _) => {
            frames += 1;
            header.flags.is_settled.then_some(())
        }
        Incoming::Message(message) => {
            stats += u64::from(matches!(**message, ServerMessage::Stats(_)));
            None
        }
    };
    mirror.receive_until("a lossless frame", &mut count);
    while let Some(incoming) = mirror.client.receive(Duration::from_millis(500)).expect("received") {
        if let Incoming::Frame(header, _) = &incoming {
            mirror.client.ack(header).expect("sent");
        }
        count(&incoming);
    }
    (frames, stats)
}

/// A follower requests stats for itself. An open view can start and stop its stats.
///
/// Rules: FRAME-13, SOCK-12
#[test]
fn only_clients_that_request_stats_get_them() {
    let (_server, [mut ada, mut ben, mut cyd]) = Server::start_with(["ada", "ben", "cyd"]);
    open(&mut ada, None, false);
    // Only an open view can be followed.
    let adas = counted(&mut ada);
    open(&mut ben, Some(&ada), true);
    open(&mut cyd, Some(&ada), false);
    let counts = [adas, counted(&mut ben), counted(&mut cyd)];
    assert!(counts.iter().all(|(frames, _)| *frames > 0), "{counts:?}");
    assert_eq!(counts.map(|(_, stats)| stats), [0, counts[1].0, 0]);

    let set_stats = |ada: &mut Mirror, stats, camera_revision| {
        let settings = ViewSettings { exposure: 0.0, solo: Vec::new() };
        ada.send(&ClientMessage::SetView { settings, stats, camera_revision });
    };
    // Without the field the setting stays.
    for (stats, camera_revision) in [(Some(true), 2), (None, 3)] {
        set_stats(&mut ada, stats, camera_revision);
        next_stats(&mut ada, |stats| stats.quality == FrameQuality::Settled);
    }
    set_stats(&mut ada, Some(false), 4);
    let (frames, stats) = counted(&mut ada);
    assert!(frames > 0 && stats == 0, "{stats} stats, {frames} frames");
    // A new view has a setting of its own.
    open(&mut ben, None, false);
    // Frames of the old view may still be in flight.
    counted(&mut ben);
    ben.edit(move_point(ada.light(), 2, moved(ada.point(2), [0.0, 0.2, 0.0])));
    let (frames, stats) = counted(&mut ben);
    assert!(frames > 0 && stats == 0, "{stats} stats, {frames} frames");
}

/// Stats that cannot be sent with their frame are not sent at all, so they do not pile up.
///
/// Rules: FRAME-13, SOCK-10
#[test]
fn a_client_that_does_not_read_has_no_more_stats_than_frames() {
    let (_server, [mut slow, mut fast]) = Server::start_with(["slow", "fast"]);
    open(&mut slow, None, true);
    open(&mut fast, None, false);
    // From its first frame on `slow` neither reads nor acknowledges.
    next_stats(&mut slow, |_| true);
    let (light, start) = (fast.light(), fast.point(2));
    let until = Instant::now() + Duration::from_secs(5);
    for step in (0..).take_while(|_| Instant::now() < until) {
        fast.edited(move_point(light, 2, oscillate(start, step)));
    }
    let mut counts: BTreeMap<u64, (usize, usize)> = BTreeMap::new();
    while let Some(incoming) = slow.client.receive(Duration::from_millis(300)).expect("received") {
        match incoming {
            Incoming::Frame(header, _) => counts.entry(header.frame).or_default().0 += 1,
            Incoming::Message(message) => {
                if let ServerMessage::Stats(stats) = *message {
                    counts.entry(stats.frame).or_default().1 += 1;
                }
            }
        }
    }
    assert!(counts.len() >= 3, "{counts:?}");
    assert!(counts.values().all(|count| *count == (1, 1)), "{counts:?}");
}

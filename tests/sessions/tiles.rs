//! Frames in parts: the tiles that are sent, and the whole picture that they form.

use std::time::{Duration, Instant};

use bench::{Incoming, Tiles};
use image::RgbImage;
use protocol::{ClientMessage, Command, Interaction, Reduction};
use stream::{FrameHeader, FrameTile};

use crate::sessions::support::{Mirror, Server, committed, move_point, moved};

const SIZE: [u16; 2] = [640, 360];

/// Opens a view that is never reduced, and waits until it is at rest.
fn open(mirror: &mut Mirror) -> (FrameHeader, Tiles) {
    let full = Interaction { shadow_map: Reduction::Full, resolution: Reduction::Full };
    mirror.open_view_of(SIZE.map(u32::from), Some(full));
    settled_frame(mirror, 1)
}

fn next(mirror: &mut Mirror, mut wanted: impl FnMut(&FrameHeader) -> bool) -> (FrameHeader, Tiles) {
    mirror.receive_until("a frame", |incoming| match incoming {
        Incoming::Frame(header, tiles) if wanted(header) => Some((*header, tiles.clone())),
        _ => None,
    })
}

fn settled_frame(mirror: &mut Mirror, seq: u64) -> (FrameHeader, Tiles) {
    next(mirror, |header| header.flags.is_settled && header.log_seq >= seq)
}

fn area(tiles: &Tiles) -> u32 {
    tiles.tiles().map(|tile| u32::from(tile.width) * u32::from(tile.height)).sum()
}

const ALL: u32 = SIZE[0] as u32 * SIZE[1] as u32;

/// Adds a small spotlight far from the demo's own light, which lights little of the picture. Returns its id.
fn add_lamp(mirror: &mut Mirror) -> u64 {
    let json = serde_json::json!({"type": "spot", "name": "lamp", "intensity": 3, "coneAngle": 4,
        "transform": {"translation": [0, 3, 4], "rotation": [-0.35, 0, 0, 0.936_749_7], "scale": 1}});
    let light = serde_json::from_value(json).expect("a light");
    let seq = mirror.edited(Command::AddLight { light }).seq().expect("committed");
    mirror.catch_up(seq);
    mirror.document.lights().keys().map(|id| id.0).max().expect("a light")
}

/// Small changes send few tiles: a whole picture for the first step, then parts of it. On the client's canvas they form
/// the same picture as a whole one, within the loss of JPEG. The lossless frame arrives in bands that cover the whole
/// picture.
///
/// Rules: FRAME-4, FRAME-12
#[test]
fn what_changes_little_is_little_to_send() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    let lamp = add_lamp(&mut ada);
    let (header, tiles) = open(&mut ada);
    assert!(tiles.tiles().count() > 1 && area(&tiles) == ALL, "bands");
    let mut canvas = RgbImage::new(SIZE[0].into(), SIZE[1].into());
    tiles.draw_on(&mut canvas).expect("pictures");
    assert!(header.flags.is_last_tile && !header.flags.is_key);

    let (base_seq, gesture) = (ada.seq, "dim".to_owned());
    ada.send(&ClientMessage::GestureBegin { gesture: gesture.clone(), light: lamp, base_seq });
    let mut parts = Vec::new();
    for update in 1..=6_u64 {
        let parameter = light::parameters::EXPOSURE.to(-(update as f64) / 4.0).into();
        let command = Command::SetLight { light: lamp, parameter };
        ada.send(&ClientMessage::GestureUpdate { gesture: gesture.clone(), update, command });
        let (_, tiles) = next(&mut ada, |header| !header.flags.is_settled);
        tiles.draw_on(&mut canvas).expect("pictures");
        parts.push(area(&tiles));
    }
    assert!(parts[1..].iter().all(|part| *part < ALL / 3), "{parts:?} of {ALL} pixels");
    assert!(parts[1..].iter().all(|part| *part > 0));

    // The parts form the picture that a new client gets as a whole.
    let mut late = server.connect("late");
    late.follow(&ada);
    let (first, tiles) = next(&mut late, |_| true);
    assert_eq!((area(&tiles), first.flags.is_key), (ALL, true), "who comes late is sent the whole");
    ada.send(&ClientMessage::GestureCommit { gesture, op_id: "dimmed".into() });
    let (_, lossless) = settled_frame(&mut ada, base_seq + 1);
    let mut truth = canvas.clone();
    lossless.draw_on(&mut truth).expect("pictures");
    let wrong = canvas.pixels().zip(truth.pixels()).filter(|(a, b)| {
        // JPEG at this quality errs by less except at edges, where samples differ too.
        (0..3).any(|k| a[k].abs_diff(b[k]) > 60)
    });
    let wrong = wrong.count();
    assert!(wrong < ALL as usize / 200, "{wrong} pixels are others");
    // The comparison detects a missing tile.
    let mut torn = truth.clone();
    let tile = FrameTile { x: 256, y: 128, width: 64, height: 64 };
    for (x, y) in (tile.y..tile.y + 64).flat_map(|y| (tile.x..tile.x + 64).map(move |x| (x, y))) {
        torn.get_pixel_mut(x.into(), y.into()).0 = [255, 0, 255];
    }
    let seen = torn.pixels().zip(truth.pixels()).filter(|(a, b)| (0..3).any(|k| a[k].abs_diff(b[k]) > 60));
    assert!(seen.count() > ALL as usize / 200);
}

/// A client that could not decode a part gets a whole picture next, during a drag and at rest. Requests for frames
/// before the latest whole one, or for frames that were never sent, are ignored.
///
/// Rules: FRAME-14
#[test]
fn who_asks_for_a_key_frame_is_sent_the_whole() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    let lamp = add_lamp(&mut ada);
    open(&mut ada);
    let (base_seq, gesture) = (ada.seq, "dim".to_owned());
    ada.send(&ClientMessage::GestureBegin { gesture: gesture.clone(), light: lamp, base_seq });
    let dim = |ada: &mut Mirror, update: u64| {
        let command = Command::SetLight {
            light: lamp,
            parameter: light::parameters::EXPOSURE.to(-(update as f64) / 4.0).into(),
        };
        ada.send(&ClientMessage::GestureUpdate { gesture: gesture.clone(), update, command });
        next(ada, |header| !header.flags.is_settled)
    };
    let mut torn = 0;
    for update in 1..=4 {
        let (header, tiles) = dim(&mut ada, update);
        assert!(update == 1 || area(&tiles) < ALL && !header.flags.is_key, "a part");
        torn = header.frame;
    }
    ada.send(&ClientMessage::RequestKeyFrame { frame: torn });
    let (whole, tiles) = next(&mut ada, |header| header.flags.is_key);
    assert!(whole.frame > torn && area(&tiles) == ALL);
    // The requested frame is older than the whole picture.
    ada.send(&ClientMessage::RequestKeyFrame { frame: torn });
    let (header, tiles) = dim(&mut ada, 5);
    assert!(area(&tiles) < ALL && !header.flags.is_key, "parts go on");

    ada.send(&ClientMessage::GestureCancel { gesture: gesture.clone() });
    let (header, at_rest) = next(&mut ada, |header| header.flags.is_settled && header.live_revision > 5);
    ada.send(&ClientMessage::RequestKeyFrame { frame: header.frame });
    let (again, tiles) = next(&mut ada, |_| true);
    assert!(
        again.frame == header.frame + 1 && again.flags.is_key && again.flags.is_settled && tiles == at_rest
    );
    for frame in [torn, header.frame, again.frame + 1, u64::MAX] {
        ada.send(&ClientMessage::RequestKeyFrame { frame });
    }
    let until = Instant::now() + Duration::from_millis(500);
    while let Some(left) = until.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
        let incoming = ada.client.receive(left).expect("received");
        assert!(!matches!(incoming, Some(Incoming::Frame(..))), "nobody lacks a frame");
    }
}

/// An edit during a lossless frame ends it: the rest is never sent, and a whole picture of the edit follows.
///
/// Rules: FRAME-12
#[test]
fn an_edit_interrupts_the_lossless_frame() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    open(&mut ada);
    let (light, point) = (ada.light(), ada.point(2));
    let mut revisions = Vec::new();
    let until = Instant::now() + Duration::from_secs(4);
    let mut step = 0;
    while Instant::now() < until {
        step += 1;
        let by = if step % 2 == 0 { 0.1 } else { -0.1 };
        committed(&ada.edited(move_point(light, 2, moved(point, [0.0, by, 0.0]))));
        // Edits come at every time of a lossless frame, from before its render to its last tile.
        let pause = Instant::now() + Duration::from_millis(240 + 15 * (step % 12));
        while let Some(left) = pause.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if let Some(Incoming::Frame(header, tiles)) = ada.client.receive(left).expect("received") {
                ada.client.ack(&header).expect("sent");
                revisions.push(header.log_seq);
                assert!(
                    !header.flags.is_settled || area(&tiles) == ALL,
                    "a lossless frame that ends is whole"
                );
            }
        }
    }
    assert!(revisions.is_sorted(), "nothing of an earlier state comes after a later one: {revisions:?}");
    let seq = ada.seq;
    let (header, tiles) = settled_frame(&mut ada, seq);
    assert_eq!((header.log_seq, area(&tiles)), (seq, ALL));
}

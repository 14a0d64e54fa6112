//! Frames in parts: the tiles that are sent, and the whole picture that they form.

use std::time::{Duration, Instant};

use bench::{Incoming, Tiles};
use image::RgbImage;
use light::parameters::EXPOSURE;
use protocol::{ClientMessage, Command, Interaction, Reduction};
use stream::{FrameHeader, FrameTile};

use crate::sessions::support::{Mirror, Server, committed, move_point, oscillate};

const SIZE: [u16; 2] = [640, 360];

/// Opens a view that is never reduced, and waits until it is at rest.
fn open(mirror: &mut Mirror) -> (FrameHeader, Tiles) {
    let full = Interaction { shadow_map: Reduction::Full, resolution: Reduction::Full };
    mirror.open_view_of(SIZE.map(u32::from), Some(full));
    mirror.settled_frame(1)
}

fn area(tiles: &Tiles) -> u32 {
    tiles.tiles().map(|tile| u32::from(tile.width) * u32::from(tile.height)).sum()
}

const ALL: u32 = SIZE[0] as u32 * SIZE[1] as u32;

/// A client with a view at rest, whose lights include a small spotlight far from the demo's own light, which lights
/// little of the picture. A gesture on the spotlight has begun.
struct Dimming {
    server: Server,
    ada: Mirror,
    lamp: u64,
}

impl Dimming {
    /// Returns the frame of the view at rest, too.
    fn start() -> (Self, FrameHeader, Tiles) {
        let (server, [mut ada]) = Server::start_with(["ada"]);
        let lamp = ada.add_lamp(3.0, 4.0);
        let (header, tiles) = open(&mut ada);
        let base_seq = ada.seq;
        ada.send(&ClientMessage::GestureBegin { gesture: "dim".into(), light: lamp, base_seq });
        (Self { server, ada, lamp }, header, tiles)
    }

    /// Dims the spotlight by an update. Returns the next moving frame.
    fn update(&mut self, update: u64) -> (FrameHeader, Tiles) {
        let parameter = EXPOSURE.to(-(update as f64) / 4.0).into();
        self.ada.update("dim", update, Command::SetLight { light: self.lamp, parameter, ignore_pins: false });
        self.ada.frame(|header| !header.flags.is_settled)
    }
}

/// Number of pixels that differ. JPEG at this quality errs by less except at edges, where samples differ too.
fn differences(a: &RgbImage, b: &RgbImage) -> usize {
    let differs = |(a, b): &(&image::Rgb<u8>, &image::Rgb<u8>)| (0..3).any(|k| a[k].abs_diff(b[k]) > 60);
    a.pixels().zip(b.pixels()).filter(differs).count()
}

/// Small changes send few tiles: a whole picture for the first step, then parts of it. On the client's canvas they form
/// the same picture as a whole one, within the loss of JPEG. The lossless frame arrives in bands that cover the whole
/// picture.
///
/// Rules: FRAME-4, FRAME-12
#[test]
fn small_changes_send_few_tiles() {
    let (mut dimming, header, tiles) = Dimming::start();
    assert!(tiles.tiles().count() > 1 && area(&tiles) == ALL, "bands");
    let mut canvas = RgbImage::new(SIZE[0].into(), SIZE[1].into());
    tiles.draw_on(&mut canvas).expect("pictures");
    assert!(header.flags.is_last_tile && !header.flags.is_key);

    let mut parts = Vec::new();
    for update in 1..=6 {
        let (_, tiles) = dimming.update(update);
        tiles.draw_on(&mut canvas).expect("pictures");
        parts.push(area(&tiles));
    }
    assert!(parts[1..].iter().all(|part| *part < ALL / 3), "{parts:?} of {ALL} pixels");
    assert!(parts[1..].iter().all(|part| *part > 0));

    // The parts form the picture that a new client gets as a whole.
    let Dimming { server, mut ada, .. } = dimming;
    let mut late = server.connect("late");
    late.follow(&ada);
    let (first, tiles) = late.frame(|_| true);
    assert_eq!((area(&tiles), first.flags.is_key), (ALL, true), "who comes late is sent the whole");
    ada.commit("dim");
    let (_, lossless) = ada.settled_frame(ada.seq + 1);
    let mut truth = canvas.clone();
    lossless.draw_on(&mut truth).expect("pictures");
    let wrong = differences(&canvas, &truth);
    assert!(wrong < ALL as usize / 200, "{wrong} pixels are others");
    // The comparison detects a missing tile.
    let mut torn = truth.clone();
    let tile = FrameTile { x: 256, y: 128, width: 64, height: 64 };
    for (x, y) in (tile.y..tile.y + 64).flat_map(|y| (tile.x..tile.x + 64).map(move |x| (x, y))) {
        torn.get_pixel_mut(x.into(), y.into()).0 = [255, 0, 255];
    }
    assert!(differences(&torn, &truth) > ALL as usize / 200);
}

/// A client that could not decode a part gets a whole picture next, during a drag and at rest. Requests for frames
/// before the latest whole one, or for frames that were never sent, are ignored.
///
/// Rules: FRAME-14
#[test]
fn a_requested_key_frame_is_the_whole_picture() {
    let (mut dimming, ..) = Dimming::start();
    let mut torn = 0;
    for update in 1..=4 {
        let (header, tiles) = dimming.update(update);
        assert!(update == 1 || area(&tiles) < ALL && !header.flags.is_key, "a part");
        torn = header.frame;
    }
    dimming.ada.send(&ClientMessage::RequestKeyFrame { frame: torn });
    let (whole, tiles) = dimming.ada.frame(|header| header.flags.is_key);
    assert!(whole.frame > torn && area(&tiles) == ALL);
    // The requested frame is older than the whole picture.
    dimming.ada.send(&ClientMessage::RequestKeyFrame { frame: torn });
    let (header, tiles) = dimming.update(5);
    assert!(area(&tiles) < ALL && !header.flags.is_key, "parts go on");

    let ada = &mut dimming.ada;
    ada.cancel("dim");
    let (header, at_rest) = ada.frame(|header| header.flags.is_settled && header.live_revision > 5);
    ada.send(&ClientMessage::RequestKeyFrame { frame: header.frame });
    let (again, tiles) = ada.frame(|_| true);
    assert!(again.frame == header.frame + 1 && again.flags.is_key && again.flags.is_settled && tiles == at_rest);
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
    let (_server, [mut ada]) = Server::start_with(["ada"]);
    open(&mut ada);
    let (light, point) = (ada.light(), ada.point(2));
    let mut revisions = Vec::new();
    let until = Instant::now() + Duration::from_secs(4);
    for step in (1..).take_while(|_| Instant::now() < until) {
        committed(&ada.edited(move_point(light, 2, oscillate(point, step))));
        // Edits come at every time of a lossless frame, from before its render to its last tile.
        let pause = Instant::now() + Duration::from_millis(240 + 15 * (step % 12));
        while let Some(left) = pause.checked_duration_since(Instant::now()).filter(|left| !left.is_zero()) {
            if let Some(Incoming::Frame(header, tiles)) = ada.client.receive(left).expect("received") {
                ada.client.ack(&header).expect("sent");
                revisions.push(header.log_seq);
                assert!(!header.flags.is_settled || area(&tiles) == ALL, "a lossless frame that ends is whole");
            }
        }
    }
    assert!(revisions.is_sorted(), "nothing of an earlier state comes after a later one: {revisions:?}");
    let seq = ada.seq;
    let (header, tiles) = ada.settled_frame(seq);
    assert_eq!((header.log_seq, area(&tiles)), (seq, ALL));
}

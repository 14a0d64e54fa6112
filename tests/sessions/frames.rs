//! Tests what is rendered, encoded and sent, and what is not.

use std::time::{Duration, Instant};

use bench::Incoming;
use protocol::{ClientMessage, Command, Document, Interaction, Reduction, ServerMessage, ViewSettings};
use stream::{Codec, FrameHeader};

use crate::sessions::support::{Mirror, Server, frame_pixels, move_point, oscillate, rename};

/// Numbers of rendered and of encoded frames.
fn work(server: &Server) -> [f64; 2] {
    ["frames_rendered_total", "frames_encoded_total"].map(|name| server.metric(name, ""))
}

/// Rules: FRAME-1, FRAME-3, FRAME-4, FRAME-7
#[test]
fn moving_is_jpeg_rest_is_lossless_and_then_nothing_happens() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    ada.open_view();
    let (first, _) = ada.frame(|_| true);
    assert_eq!((first.codec, first.log_seq, first.camera_revision), (Codec::Jpeg, ada.seq, 1));
    let (settled, _) = ada.settled_frame(0);
    assert_eq!((settled.codec, settled.log_seq), (Codec::Png, ada.seq));

    let seq = ada.shift_point(2, [0.0, 0.3, 0.0]);
    let (moving, _) = ada.frame(|header| header.log_seq == seq);
    assert_eq!(moving.codec, Codec::Jpeg);
    let (settled, _) = ada.settled_frame(0);
    assert_eq!((settled.codec, settled.log_seq, settled.width, settled.height), (Codec::Png, seq, 160, 90));

    // At rest, and after a change that no picture shows, nothing is drawn, encoded or sent.
    let at_rest = work(&server);
    ada.edited(rename(ada.light(), "another name"));
    let until = Instant::now() + idle_for();
    while Instant::now() < until {
        let incoming = ada.client.receive(Duration::from_millis(100)).expect("received");
        assert!(!matches!(incoming, Some(Incoming::Frame(..))), "a frame at rest");
    }
    assert_eq!(work(&server), at_rest);

    // The counters detect work if there is some.
    ada.shift_point(2, [0.0, -0.3, 0.0]);
    ada.settled_frame(0);
    assert!(work(&server)[0] > at_rest[0] && work(&server)[1] > at_rest[1]);
}

/// Several settle times; `BENDYLIGHTS_IDLE_S=60` waits for a minute.
fn idle_for() -> Duration {
    let seconds = std::env::var("BENDYLIGHTS_IDLE_S").ok().and_then(|text| text.parse().ok());
    Duration::from_secs(seconds.unwrap_or(3))
}

/// Frames that arrive within a moment. They are not acknowledged.
fn unacknowledged(mirror: &mut Mirror) -> Vec<FrameHeader> {
    let incoming = std::iter::from_fn(|| mirror.client.receive(Duration::from_millis(50)).expect("received"));
    incoming
        .filter_map(|incoming| if let Incoming::Frame(header, _) = incoming { Some(header) } else { None })
        .collect()
}

/// Rules: FRAME-2
#[test]
fn no_more_than_three_frames_are_under_way() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    ada.open_view();
    // Ada acknowledges the first frame. From then on she reads but does not acknowledge.
    ada.frame(|_| true);
    let mut frames: Vec<FrameHeader> = Vec::new();
    let mut edits = 0;
    let mut edit_and_read = |ada: &mut Mirror, frames: &mut Vec<FrameHeader>| {
        edits += 1;
        ben.shift_point(2, oscillate([0.0; 3], edits));
        frames.extend(unacknowledged(ada));
    };
    while frames.len() < 3 {
        edit_and_read(&mut ada, &mut frames);
    }
    // The window is full now; later states are not drawn for her.
    for _ in 0..4 {
        edit_and_read(&mut ada, &mut frames);
    }
    let latest = ben.seq;
    assert_eq!(frames.len(), 3, "frames without an acknowledgement");
    assert!(frames[2].log_seq < latest, "the last edits were drawn for nobody");
    // The latest state wins: an acknowledgement brings the current state, not the missed ones.
    for header in &frames {
        ada.client.ack(header).expect("sent");
    }
    let last = frames[2].frame;
    let next = ada.client.wait_for("a frame", |incoming| match incoming {
        Incoming::Frame(header, _) if header.frame > last => Some(header),
        _ => None,
    });
    assert_eq!(next.expect("a frame").log_seq, latest);
}

/// Rules: FRAME-6
#[test]
fn nothing_is_drawn_for_a_client_that_acknowledges_nothing() {
    let (server, [mut silent, mut fast]) = Server::start_with(["silent", "fast"]);
    silent.open_view();
    fast.open_view();
    fast.settled_frame(0);
    // From here on `silent` neither reads nor acknowledges: one frame is in flight to it.
    let before = work(&server);
    let (mut shown, until) = (0, Instant::now() + Duration::from_secs(3));
    while Instant::now() < until {
        shown += 1;
        let seq = fast.shift_point(2, oscillate([0.0; 3], shown));
        fast.frame(|header| header.log_seq == seq);
    }
    // Every edit of the fast client came back as a frame of its own; a window that waited for the silent client would
    // have stopped after three.
    assert!(shown > 3, "{shown} edits in 3 s");
    // The planted fault, an earlier version, drew a frame per window and two seconds for the silent client too.
    // Lossless frames of the fast client come in addition.
    let drawn = work(&server)[0] - before[0];
    assert!(drawn <= 2.0 * shown as f64, "{drawn} pictures for {shown} edits");
    let frames = unacknowledged(&mut silent);
    assert_eq!(frames.len(), 1, "{frames:?}");
    // The silent client continues after its acknowledgement.
    silent.client.ack(&frames[0]).expect("sent");
    let (next, _) = silent.frame(|header| header.frame > 1);
    assert_eq!(next.log_seq, fast.seq);
}

/// Rules: FRAME-5
#[test]
fn followers_share_one_render_and_one_encoding() {
    let (server, [mut ada, ben, cyd]) = Server::start_with(["ada", "ben", "cyd"]);
    ada.open_view();
    ada.settled_frame(0);
    let mut followers = [ben, cyd];
    for follower in &mut followers {
        follower.follow(&ada);
        let (header, _) = follower.settled_frame(0);
        assert_eq!((header.width, header.height), (160, 90), "the followed one's size");
    }
    // Nothing is in flight any more; counting starts here.
    let before = work(&server);
    let seq = ada.shift_point(2, [0.0, 0.3, 0.0]);
    let lossless = |header: &FrameHeader| header.flags.is_settled && header.log_seq == seq;
    let (_, hers) = ada.frame(lossless);
    for follower in &mut followers {
        let (_, theirs) = follower.frame(lossless);
        assert!(theirs == hers, "the same bytes");
    }
    let after = work(&server);
    assert_eq!([after[0] - before[0], after[1] - before[1]], [2.0, 2.0], "one moving, one lossless, for three");
}

/// A client that leaves its own view for that of another client, which is at rest, gets the picture of that view.
///
/// Rules: FRAME-5
#[test]
fn a_follower_that_leaves_its_own_view_sees_the_followed_one() {
    let (_server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    ada.open_view_of([320, 200], None);
    ada.settled_frame(0);
    ben.open_view();
    ben.settled_frame(0);
    ben.follow(&ada);
    let (header, _) = ben.frame(|header| header.flags.is_settled && header.view_width == 320);
    assert_eq!((header.width, header.height), (320, 200));
}

/// Rules: SOCK-7, FRAME-1
#[test]
fn moving_ones_view_is_no_edit() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    ada.open_view();
    let before = ada.settled(ada.seq);
    ada.move_camera([0.3, 0.0, 0.0], 7);
    let (header, payload) = ada.frame(|header| header.flags.is_settled && header.camera_revision == 7);
    assert_eq!(header.log_seq, ada.seq);
    assert_ne!(frame_pixels(&header, &payload), before);
    assert_eq!(server.state().0, ada.seq);
    let bounds = ada.client.welcome.bounds;
    assert!(bounds.min.iter().zip(bounds.max).all(|(min, max)| *min < max));
    assert_eq!(Document::from(&ada.document).cameras.len(), 1);
}

/// Exposure and solo are private to a viewer: no record, and no frame for other clients.
///
/// Rules: SOCK-7, SOCK-12, FRAME-1
#[test]
fn view_settings_are_private() {
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let (key, added) = (ada.light(), ada.add_lamp(30.0, 40.0));
    let seq = ada.seq;
    assert_ne!(key, added);
    ada.open_view();
    ben.open_view();
    let (both, bens) = (ada.settled(seq), ben.settled(seq));
    let mut revision = 1;
    let mut seen_with = |ada: &mut Mirror, exposure: f64, solo: &[u64]| {
        revision += 1;
        let settings = ViewSettings { exposure, solo: solo.to_vec() };
        ada.send(&ClientMessage::SetView { settings, stats: None, camera_revision: revision });
        let (header, payload) = ada.frame(|header| header.flags.is_settled && header.camera_revision == revision);
        frame_pixels(&header, &payload)
    };
    let sum = |picture: &[u8]| picture.iter().map(|byte| u64::from(*byte)).sum::<u64>();
    let before = work(&server);
    let [alone, lamp_alone] = [&[key], &[added]].map(|solo| seen_with(&mut ada, 0.0, solo));
    assert!(sum(&alone) < sum(&both) && sum(&lamp_alone) < sum(&both) && alone != lamp_alone);
    // The order of ids does not matter; an unknown light is ignored.
    assert!(seen_with(&mut ada, 0.0, &[added, 99, key]) == both);
    assert!(seen_with(&mut ada, 0.0, &[99]) == both);
    assert!(sum(&seen_with(&mut ada, 1.0, &[])) > sum(&both));
    assert!(sum(&seen_with(&mut ada, -1.0, &[])) < sum(&both));
    // Only Ada's pictures were drawn, each at most twice, moving and lossless.
    assert!(work(&server)[0] - before[0] <= 12.0);
    assert_eq!(server.state().0, seq, "nothing was logged");
    // A follower sees the picture of the followed view.
    seen_with(&mut ada, 0.0, &[key]);
    ben.follow(&ada);
    let (header, followed) = ben.frame(|header| header.flags.is_settled && header.camera_revision == revision);
    assert!(frame_pixels(&header, &followed) == alone && bens == both);
    // Removing the light ends its solo.
    let gone = ada.edited(Command::RemoveLight { light: key }).seq().expect("committed");
    assert!(ada.settled(gone) == lamp_alone);

    for (exposure, solo, sentence) in [(33.0, vec![], "from -32 to 32"), (0.0, vec![1; 257], "256")] {
        let settings = ViewSettings { exposure, solo };
        ada.send(&ClientMessage::SetView { settings, stats: None, camera_revision: 99 });
        let said = ada.wait_for("a refusal", |message| match message {
            ServerMessage::Error { message, fatal: false, .. } => Some(message.clone()),
            _ => None,
        });
        assert!(said.contains(sentence), "{said}");
    }
}

/// Drags for `seconds` in a view that requests `interaction`. Returns the headers of the drag's frames, and that of the
/// lossless one.
fn dragged(server: &Server, interaction: Option<Interaction>, seconds: u64) -> (Vec<FrameHeader>, FrameHeader) {
    let mut ada = server.connect("ada");
    ada.open_view_of([1280, 720], interaction);
    ada.settled_frame(0);
    let (light, start) = (ada.light(), ada.point(2));
    ada.begin("drag");
    let (mut frames, until) = (Vec::new(), Instant::now() + Duration::from_secs(seconds));
    for update in (1..).take_while(|_| Instant::now() < until) {
        ada.update("drag", update, move_point(light, 2, oscillate(start, update)));
        frames.push(ada.frame(|header| !header.flags.is_settled).0);
    }
    ada.cancel("drag");
    (frames, ada.settled_frame(0).0)
}

/// Size and map divisor of a frame, which the client compares with those of its view.
fn detail_of(header: &FrameHeader) -> (u16, u16, u16) {
    (header.width, header.height, header.shadow_map_divisor)
}

/// A moving picture that would be too slow has fewer texels, and has fewer pixels only if the client requested that.
/// Forbidden reductions are not made, and none are made at rest.
///
/// Rules: FRAME-10
#[test]
fn moving_pictures_are_reduced_as_far_as_is_allowed_and_lossless_ones_never() {
    let server = Server::start();
    let [both, neither] = [Reduction::Auto, Reduction::Full]
        .map(|reduction| Interaction { shadow_map: reduction, resolution: reduction });
    let slow =
        |frames: &[FrameHeader]| frames.iter().take(6).all(|header| header.render_us + header.encode_us > 40_000);
    for (interaction, least) in [(Some(both), (640, 360, 2)), (None, (1280, 720, 2)), (Some(neither), FULL)] {
        let (frames, settled) = dragged(&server, interaction, 3);
        assert_eq!(detail_of(&settled), FULL, "{interaction:?}");
        assert!(frames.iter().all(|header| (header.view_width, header.view_height) == (1280, 720)));
        assert_eq!(detail_of(&frames[0]), FULL, "it begins in full");
        let within = |header: &FrameHeader| {
            let (width, height, divisor) = detail_of(header);
            width >= least.0 && height >= least.1 && divisor <= least.2
        };
        assert!(frames.iter().all(within), "{interaction:?}");
        // A fast device needs no reduction.
        let reduced = frames.iter().any(|header| detail_of(header) != FULL);
        assert!(least == FULL || reduced || !slow(&frames), "{interaction:?}: slow, and nothing was reduced");
        // Three seconds have room for three changes.
        let changes = frames.windows(2).filter(|pair| detail_of(&pair[0]) != detail_of(&pair[1])).count();
        assert!(changes <= 3, "{changes} changes");
    }
}

/// 1280 x 720 pixels with maps of full size.
const FULL: (u16, u16, u16) = (1280, 720, 1);

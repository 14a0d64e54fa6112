//! Tests what is rendered, encoded and sent, and what is not.

use std::time::{Duration, Instant};

use bench::{Incoming, Tiles};
use protocol::{ClientMessage, Command, Document, Interaction, Reduction, ServerMessage, Vec3, ViewSettings};
use serde_json::json;
use stream::{Codec, FrameHeader};

use crate::sessions::support::{Mirror, Server, frame_pixels, move_point, moved, rename};

/// Numbers of rendered and of encoded frames.
fn work(server: &Server) -> [f64; 2] {
    ["bendylights_frames_rendered_total", "bendylights_frames_encoded_total"]
        .map(|name| server.process.metric(name, "").expect("counted"))
}

fn frame(mirror: &mut Mirror, mut wanted: impl FnMut(&FrameHeader) -> bool) -> (FrameHeader, Tiles) {
    mirror.receive_until("a frame", |incoming| match incoming {
        Incoming::Frame(header, tiles) if wanted(header) => Some((*header, tiles.clone())),
        _ => None,
    })
}

/// Rules: FRAME-1, FRAME-3, FRAME-4, FRAME-7
#[test]
fn moving_is_jpeg_rest_is_lossless_and_then_nothing_happens() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    ada.open_view();
    let (first, _) = frame(&mut ada, |_| true);
    assert_eq!((first.codec, first.log_seq, first.camera_revision), (Codec::Jpeg, ada.seq, 1));
    let (settled, _) = frame(&mut ada, |header| header.flags.is_settled);
    assert_eq!((settled.codec, settled.log_seq), (Codec::Png, ada.seq));

    let light = ada.light();
    let result = ada.edited(move_point(light, 2, moved(ada.point(2), [0.0, 0.3, 0.0])));
    let seq = result.seq().expect("committed");
    let (moving, _) = frame(&mut ada, |header| header.log_seq == seq);
    assert_eq!(moving.codec, Codec::Jpeg);
    let (settled, _) = frame(&mut ada, |header| header.flags.is_settled);
    assert_eq!((settled.codec, settled.log_seq, settled.width, settled.height), (Codec::Png, seq, 160, 90));

    // At rest, and after a change that no picture shows, nothing is drawn, encoded or sent.
    let at_rest = work(&server);
    ada.edited(rename(light, "another name"));
    let until = Instant::now() + idle_for();
    while Instant::now() < until {
        let incoming = ada.client.receive(Duration::from_millis(100)).expect("received");
        assert!(!matches!(incoming, Some(Incoming::Frame(..))), "a frame at rest");
    }
    assert_eq!(work(&server), at_rest);

    // The counters detect work if there is some.
    ada.edited(move_point(light, 2, moved(ada.point(2), [0.0, -0.3, 0.0])));
    frame(&mut ada, |header| header.flags.is_settled);
    assert!(work(&server)[0] > at_rest[0] && work(&server)[1] > at_rest[1]);
}

/// Several settle times; `BENDYLIGHTS_IDLE_S=60` waits for a minute.
fn idle_for() -> Duration {
    let seconds = std::env::var("BENDYLIGHTS_IDLE_S").ok().and_then(|text| text.parse().ok());
    Duration::from_secs(seconds.unwrap_or(3))
}

/// `position`, moved to one side at even steps and to the other at odd ones.
fn oscillate(position: Vec3, step: u32) -> Vec3 {
    moved(position, [0.0, if step.is_multiple_of(2) { 0.1 } else { -0.1 }, 0.0])
}

/// Frames that arrive within a moment. They are not acknowledged.
fn unacknowledged(mirror: &mut Mirror) -> Vec<FrameHeader> {
    let mut frames = Vec::new();
    while let Some(incoming) = mirror.client.receive(Duration::from_millis(50)).expect("received") {
        if let Incoming::Frame(header, _) = incoming {
            frames.push(header);
        }
    }
    frames
}

/// Rules: FRAME-2
#[test]
fn no_more_than_three_frames_are_under_way() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    let mut ben = server.connect("ben");
    let light = ada.light();
    ada.open_view();
    // Ada acknowledges the first frame. From then on she reads but does not acknowledge.
    frame(&mut ada, |_| true);
    let mut frames: Vec<FrameHeader> = Vec::new();
    let mut edits = 0;
    let mut edit_and_read = |ada: &mut Mirror, frames: &mut Vec<FrameHeader>| {
        edits += 1;
        ben.edited(move_point(light, 2, oscillate(ben.point(2), edits)));
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
    let server = Server::start();
    let mut silent = server.connect("silent");
    let mut fast = server.connect("fast");
    silent.open_view();
    fast.open_view();
    frame(&mut fast, |header| header.flags.is_settled);
    let light = fast.light();
    // From here on `silent` neither reads nor acknowledges: one frame is in flight to it.
    let before = work(&server);
    let mut shown = 0;
    let until = Instant::now() + Duration::from_secs(3);
    while Instant::now() < until {
        shown += 1;
        let seq =
            fast.edited(move_point(light, 2, oscillate(fast.point(2), shown))).seq().expect("committed");
        frame(&mut fast, |header| header.log_seq == seq);
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
    let (next, _) = frame(&mut silent, |header| header.frame > 1);
    assert_eq!(next.log_seq, fast.seq);
}

/// Rules: FRAME-5
#[test]
fn followers_share_one_render_and_one_encoding() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    ada.open_view();
    frame(&mut ada, |header| header.flags.is_settled);
    let mut followers = [server.connect("ben"), server.connect("cyd")];
    for follower in &mut followers {
        follower.follow(&ada);
        let (header, _) = frame(follower, |header| header.flags.is_settled);
        assert_eq!((header.width, header.height), (160, 90), "the followed one's size");
    }
    // Nothing is in flight any more; counting starts here.
    let before = work(&server);
    let light = ada.light();
    let seq =
        ada.edited(move_point(light, 2, moved(ada.point(2), [0.0, 0.3, 0.0]))).seq().expect("committed");
    let lossless = |header: &FrameHeader| header.flags.is_settled && header.log_seq == seq;
    let (_, hers) = frame(&mut ada, lossless);
    for follower in &mut followers {
        let (_, theirs) = frame(follower, lossless);
        assert!(theirs == hers, "the same bytes");
    }
    let after = work(&server);
    assert_eq!(
        [after[0] - before[0], after[1] - before[1]],
        [2.0, 2.0],
        "one moving, one lossless, for three"
    );
}

/// A client that leaves its own view for that of another client, which is at rest, gets the picture of that view.
///
/// Rules: FRAME-5
#[test]
fn who_leaves_a_view_of_their_own_sees_the_followed_one() {
    let server = Server::start();
    let (mut ada, mut ben) = (server.connect("ada"), server.connect("ben"));
    ada.open_view_of([320, 200], None);
    frame(&mut ada, |header| header.flags.is_settled);
    ben.open_view();
    frame(&mut ben, |header| header.flags.is_settled);
    ben.follow(&ada);
    let (header, _) = frame(&mut ben, |header| header.flags.is_settled && header.view_width == 320);
    assert_eq!((header.width, header.height), (320, 200));
}

/// Rules: SOCK-7, FRAME-1
#[test]
fn moving_ones_view_is_no_edit() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    ada.open_view();
    let before = ada.settled(ada.seq);
    let mut camera = ada.client.welcome.camera.clone();
    camera.translation = moved(camera.translation, [0.3, 0.0, 0.0]);
    ada.send(&ClientMessage::SetCamera { camera, camera_revision: 7 });
    let (header, payload) = frame(&mut ada, |header| header.flags.is_settled && header.camera_revision == 7);
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
    let server = Server::start();
    let [mut ada, mut ben] = ["ada", "ben"].map(|name| server.connect(name));
    let spot = Command::AddLight { light: lamp() };
    let seq = ada.edited(spot).seq().expect("committed");
    let (key, added) = (ada.light(), ada.document.lights().keys().map(|id| id.0).max().expect("a light"));
    assert_ne!(key, added);
    ada.open_view();
    ben.open_view();
    let (both, bens) = (ada.settled(seq), ben.settled(seq));
    let mut revision = 1;
    let mut seen_with = |ada: &mut Mirror, exposure: f64, solo: &[u64]| {
        revision += 1;
        let settings = ViewSettings { exposure, solo: solo.to_vec() };
        ada.send(&ClientMessage::SetView { settings, stats: None, camera_revision: revision });
        let (header, payload) =
            frame(ada, |header| header.flags.is_settled && header.camera_revision == revision);
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
    let (header, followed) =
        frame(&mut ben, |header| header.flags.is_settled && header.camera_revision == revision);
    assert!(frame_pixels(&header, &followed) == alone && bens == both);
    // Removing the light ends its solo.
    let gone = ada.edited(Command::RemoveLight { light: key }).seq().expect("committed");
    assert!(ada.settled(gone) == lamp_alone);

    for (exposure, solo, sentence) in [(33.0, vec![], "from -32 to 32"), (0.0, vec![1; 257], "256")] {
        ada.send(&ClientMessage::SetView {
            settings: ViewSettings { exposure, solo },
            stats: None,
            camera_revision: 99,
        });
        let said = ada.wait_for("a refusal", |message| match message {
            ServerMessage::Error { message, fatal: false, .. } => Some(message.clone()),
            _ => None,
        });
        assert!(said.contains(sentence), "{said}");
    }
}

/// Drags for `seconds` in a view that requests `interaction`. Returns the headers of the drag's frames, and that of the
/// lossless one.
fn dragged(
    server: &Server,
    interaction: Option<Interaction>,
    seconds: u64,
) -> (Vec<FrameHeader>, FrameHeader) {
    let mut ada = server.connect("ada");
    ada.open_view_of([1280, 720], interaction);
    frame(&mut ada, |header| header.flags.is_settled);
    let (light, start, base_seq) = (ada.light(), ada.point(2), ada.seq);
    let gesture = "drag".to_owned();
    ada.send(&ClientMessage::GestureBegin { gesture: gesture.clone(), light, base_seq });
    let (mut frames, until) = (Vec::new(), Instant::now() + Duration::from_secs(seconds));
    for update in 1.. {
        if Instant::now() >= until {
            break;
        }
        let command = move_point(light, 2, oscillate(start, update as u32));
        ada.send(&ClientMessage::GestureUpdate { gesture: gesture.clone(), update, command });
        frames.push(frame(&mut ada, |header| !header.flags.is_settled).0);
    }
    ada.send(&ClientMessage::GestureCancel { gesture });
    (frames, frame(&mut ada, |header| header.flags.is_settled).0)
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
    let slow = |frames: &[FrameHeader]| {
        frames.iter().take(6).all(|header| header.render_us + header.encode_us > 40_000)
    };
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

/// A spotlight in addition to the demo's own light.
fn lamp() -> protocol::Light {
    let json = json!({"type": "spot", "name": "lamp", "intensity": 30,
        "transform": {"translation": [0, 3, 4], "rotation": [0, 0, 0, 1], "scale": 1}});
    serde_json::from_value(json).expect("a light")
}

//! Pictures over HTTP, and shared frames.

use light::parameters::{CONE_ANGLE, EXPOSURE, NAME};
use protocol::{ClientMessage, Command, Interaction, Reduction, ViewSource};
use serde_json::json;
use stream::{Codec, FrameTile};

use crate::client::{Client, edit, get, new_session, open_view};
use crate::server::SHARED;

/// Rules: HTTP-8
#[test]
fn a_picture_shows_the_document_as_it_is_or_was() {
    new_session(&SHARED, "pictured");
    let picture = |query: &str| {
        let answer = get(&SHARED, &format!("/sessions/pictured/render?size=64x36{query}"));
        assert_eq!((answer.status, answer.kind.as_str()), (200, "image/png"), "{query}");
        answer.body
    };
    let before = picture("");
    assert_eq!(before[..8], *b"\x89PNG\r\n\x1a\n");
    // The first chunk of a PNG has width and height.
    assert_eq!(before[16..24], [0, 0, 0, 64, 0, 0, 0, 36]);
    let dark = json!({"edits": [{"command": {"type": "removeLight", "light": 1}}]});
    edit(&SHARED, "pictured", &dark);
    assert_ne!(picture(""), before, "without its light the picture is another");
    assert_eq!(picture("&at=1"), before);
    assert_eq!(picture("&at=1&camera=camera"), before);
    assert_ne!(picture("&at=1&aov=visibility&light=key"), before);

    // Without a size: 16:9, or the frame of the camera, which has a film gate.
    let size = |query: &str| {
        let png = get(&SHARED, &format!("/sessions/pictured/render?{query}")).body;
        let side = |at: usize| u32::from_be_bytes([png[at], png[at + 1], png[at + 2], png[at + 3]]);
        [side(16), side(20)]
    };
    let wide = json!({"name": "wide", "translation": [0, 2, 5], "rotation": [0, 0, 0, 1],
        "projection": {"perspective": {"yfov": 0.4, "aspectRatio": 2.5, "znear": 0.1}}});
    let add = json!({"edits": [{"command": {"type": "addCamera", "camera": wide}}]});
    edit(&SHARED, "pictured", &add);
    assert_eq!([size(""), size("camera=wide")], [[640, 360], [759, 304]]);

    let exr = get(&SHARED, "/sessions/pictured/render?size=64x36&aov=depth&format=exr");
    assert_eq!((exr.kind.as_str(), &exr.body[..4]), ("image/x-exr", &[0x76, 0x2f, 0x31, 0x01][..]));
    for query in ["at=99", "camera=nobody", "aov=t&light=nothing"] {
        let missing = get(&SHARED, &format!("/sessions/pictured/render?{query}"));
        assert_eq!(missing.refusal(), (404, "notFound".into()), "{query}");
    }
}

/// Rules: FRAME-1, FRAME-3, FRAME-4, FRAME-5, FRAME-7
#[tokio::test]
async fn a_follower_sees_the_same_frames() {
    new_session(&SHARED, "followed");
    let (mut ada, welcome) = Client::join(&SHARED, "followed", "Ada").await;
    let (mut bob, _) = Client::join(&SHARED, "followed", "Bob").await;
    let size = [64, 36];
    ada.say(&open_view(ViewSource::Own(welcome.camera.clone()), size)).await;
    let (moving, settled) = (ada.frame().await, ada.frame().await);
    assert_eq!((moving.codec, settled.codec), (Codec::Jpeg, Codec::Png));
    assert!(settled.flags.is_settled && moving.flags.is_key && !settled.flags.is_key);
    assert_eq!((settled.log_seq, settled.camera_revision, settled.frame), (1, 7, 2));

    // An existing picture is not made again, so its timings are the same.
    bob.say(&open_view(ViewSource::Follow(welcome.client), size)).await;
    let shared = bob.frame().await;
    assert_eq!((shared.codec, shared.frame), (Codec::Png, 1));
    assert_eq!((shared.render_us, shared.encode_us), (settled.render_us, settled.encode_us));

    // A name is not visible, so the next frame is of the edit after it.
    for (op_id, parameter) in [("name", NAME.to("lamp".into()).into()), ("narrow", CONE_ANGLE.to(15.0).into())] {
        ada.say_edit(op_id, 1, Command::SetLight { light: 1, parameter, ignore_pins: false }).await;
    }
    for _ in 0..2 {
        let (hers, his) = (ada.frame().await, bob.frame().await);
        assert_eq!((hers.log_seq, his.log_seq), (3, 3));
        assert_eq!((hers.render_us, hers.encode_us), (his.render_us, his.encode_us), "one render, one encoding");
    }
}

/// A client that edits in the middle of a lossless frame does not get its rest, but the complete new picture.
///
/// Rules: FRAME-2, FRAME-12
#[tokio::test]
async fn an_edit_ends_a_lossless_frame_under_way() {
    new_session(&SHARED, "interrupted");
    let (mut ada, welcome) = Client::join(&SHARED, "interrupted", "Ada").await;
    // A large view has many tiles, each sent after the one before was taken.
    let (width, height, camera_revision, settings) = (2400, 2000, 1, None);
    let full = Some(Interaction { shadow_map: Reduction::Full, resolution: Reduction::Full });
    let source = ViewSource::Own(welcome.camera.clone());
    let view =
        ClientMessage::OpenView { source, width, height, camera_revision, settings, interaction: full, stats: false };
    ada.say(&view).await;
    let moving = ada.frame().await;
    assert_eq!((moving.codec, moving.flags.is_last_tile), (Codec::Jpeg, true));
    let first = ada.tile().await;
    assert!(first.flags.is_settled && !first.flags.is_last_tile, "a lossless frame has many tiles");

    let parameter = EXPOSURE.to(-1.0).into();
    ada.say_edit("dim", 1, Command::SetLight { light: 1, parameter, ignore_pins: false }).await;
    let next = loop {
        let tile = ada.tile().await;
        if tile.frame != first.frame {
            break tile;
        }
        assert!(!tile.flags.is_last_tile, "the lossless frame of what is gone went on to its end");
    };
    let FrameTile { x, y, width, height } = next.tile;
    assert_eq!((next.codec, next.log_seq, next.flags.is_last_tile), (Codec::Jpeg, 2, true));
    assert_eq!((x, y, width, height), (0, 0, next.width, next.height), "it is whole");
    // Its acknowledgement also counts for the incomplete one. The next lossless frame arrives completely.
    ada.say(&ClientMessage::Ack { frame: next.frame }).await;
    let settled = ada.frame().await;
    assert!(settled.flags.is_settled && settled.log_seq == 2);
}

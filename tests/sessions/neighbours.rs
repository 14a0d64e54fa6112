//! The loss of one client to another, in counts. `bendylights bench neighbours` measures times.

use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use bench::isolation::scenes;
use bench::{Client, Incoming};
use protocol::{ClientMessage, ErrorCode, ServerMessage};
use serde_json::json;
use stream::FrameHeader;

use crate::sessions::support::{
    Mirror, Server, begin_request, move_point, oscillate, own_view, view_message, wait_until,
};

/// Requests a still of another session, whose scene takes minutes to draw, on a connection that is not read.
fn heavy_still(server: &Server, name: &str, scene: &[u8]) -> TcpStream {
    let uploaded = server.address.post(&format!("/assets?name={name}"), scene).expect("answered");
    let answer: serde_json::Value = serde_json::from_str(&uploaded.text()).expect("JSON");
    let notes = answer["notes"].to_string();
    assert!(notes.contains("take long"), "what it costs is named: {notes}");
    assert_eq!(server.post("/sessions", &json!({"name": name, "scene": answer["asset"]})).status, 201);
    begin_request(&server.address, "GET", &format!("/sessions/{name}/render?size=64x36"), "")
}

/// A still that the GPU or the CPU would draw for a minute in one piece yields in the middle while others draw, and
/// ends when its client disconnects.
///
/// Rules: HTTP-8, FRAME-16
#[test]
fn a_scene_that_takes_long_yields_to_others_and_ends_with_its_client() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    ada.open_view();
    let (light, start) = (ada.light(), ada.point(2));
    let still = heavy_still(&server, "sheets", &scenes::triangles(64_000, "sheets"));
    let turns = || server.metric("still_turns_total", "");
    wait_until("the still's first turn", || turns() > 0.0);
    for step in 0..10 {
        let seq = ada.edited(move_point(light, 2, oscillate(start, step))).seq().expect("committed");
        ada.frame(|header| header.log_seq == seq);
    }
    // The still is not finished: the edits above were drawn between its turns.
    let so_far = turns();
    wait_until("another turn of the still", || turns() > so_far);
    assert!(server.metric("least_still_turns", "") > 0.0);
    drop(still);
    wait_until("the end of the still", || server.metric("least_still_turns", "") == 0.0);
    let ended = turns();
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(turns(), ended, "nobody waits for it any more");
}

/// Moves the cameras of all clients. Returns the latest moving frame of each, and the codes of the errors that they
/// got.
fn moving_frames(mirrors: &mut [Mirror], rounds: u32) -> (Vec<FrameHeader>, Vec<ErrorCode>) {
    let (mut latest, mut codes) = (Vec::new(), Vec::new());
    for round in 1..=rounds {
        for mirror in mirrors.iter_mut() {
            mirror.move_camera([0.001 * f64::from(round), 0.0, 0.0], 1 + round);
        }
        latest.clear();
        for mirror in mirrors.iter_mut() {
            latest.push(mirror.receive_until("a frame", |incoming| match incoming {
                Incoming::Frame(header, _) if header.camera_revision == 1 + round => Some(*header),
                Incoming::Message(message) => {
                    if let ServerMessage::Error { code, fatal: false, .. } = &**message {
                        codes.push(*code);
                    }
                    None
                }
                Incoming::Frame(..) => None,
            }));
        }
    }
    (latest, codes)
}

/// A view counts for five seconds after its last moving picture. Each of the four must draw another one within that
/// time.
///
/// Rules: FRAME-15
#[test]
fn the_views_of_an_actor_move_so_many_pixels_at_most() {
    let server = Server::start();
    let size = [1800, 1200];
    let open = |actor: &str| {
        let mut mirror = server.connect(actor);
        mirror.open_view_of(size, None);
        mirror
    };
    // Four views of one actor exceed 3840 x 2160; those of four actors keep their size.
    let mut own: Vec<Mirror> = (0..4).map(|_| open("ada")).collect();
    let (frames, codes) = moving_frames(&mut own, 5);
    let pixels = |frames: &[FrameHeader]| -> u64 {
        frames.iter().map(|header| u64::from(header.width) * u64::from(header.height)).sum()
    };
    assert!(pixels(&frames) <= 3840 * 2160, "{frames:?}");
    assert!(frames.iter().all(|header| [header.view_width, header.view_height].map(u32::from) == size));
    assert!(!codes.is_empty() && codes.len() <= 4, "each is told once: {codes:?}");
    assert!(codes.iter().all(|code| *code == ErrorCode::TooMany), "{codes:?}");
    drop(own);
    let mut others: Vec<Mirror> = ["ben", "cyd", "dan", "eve"].map(open).into();
    let (frames, codes) = moving_frames(&mut others, 2);
    assert!(pixels(&frames) == 4 * 1800 * 1200 && codes.is_empty(), "{frames:?} {codes:?}");
}

/// Rules: HTTP-9
#[test]
fn sessions_share_a_scene_on_the_device() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    let kept = || server.metric("render_bytes", "scenes");
    ada.open_view();
    ada.frame(|_| true);
    let before = kept();
    assert!(before > 0.0);
    assert_eq!(server.post("/sessions", &json!({"name": "second", "scene": "demo:vases"})).status, 201);
    let mut ben = Client::connect(&server.address, "second", "ben", None).expect("welcome");
    ben.send(&view_message(own_view(&ben), [160, 90], None, false)).expect("sent");
    let frame = ben.wait_for("a frame", |incoming| matches!(incoming, Incoming::Frame(..)).then_some(()));
    frame.expect("a frame");
    // The planted fault, a copy per session, has twice as much.
    assert!(kept() < 1.5 * before, "{} bytes of scenes, {before} for one session", kept());
}

/// Seconds until `count` pings are answered, more than the saved allowance.
fn seconds_of_pings(client: &mut Client, count: u32) -> f64 {
    let start = Instant::now();
    for ping in 1..=count {
        client.send(&ClientMessage::Ping { sent: f64::from(ping) }).expect("sent");
    }
    let is_last =
        |message: &ServerMessage| matches!(message, ServerMessage::Pong { sent, .. } if *sent == f64::from(count));
    let last = |incoming| matches!(incoming, Incoming::Message(message) if is_last(&message)).then_some(());
    client.wait_for("the last pong", last).expect("answered");
    start.elapsed().as_secs_f64()
}

/// Messages that are read later are not lost. Without an interactive client they are read at once.
///
/// Rules: HTTP-28
#[test]
fn busy_senders_are_throttled_while_another_client_interacts() {
    let (_server, [mut ada, ben]) = Server::start_with(["ada", "ben"]);
    ada.open_view();
    let mut ben = ben.client;
    let is_over = AtomicBool::new(false);
    let (moves, moving) = mpsc::sync_channel(1);
    let beside = std::thread::scope(|scope| {
        let is_over = &is_over;
        scope.spawn(move || {
            let mut revision = 1;
            while !is_over.load(Ordering::Relaxed) {
                revision += 1;
                ada.move_camera([0.001 * f64::from(revision), 0.0, 0.0], revision);
                ada.frame(|header| header.camera_revision == revision);
                let _ = moves.try_send(());
            }
        });
        moving.recv().expect("a moving picture");
        let beside = seconds_of_pings(&mut ben, 1_200);
        is_over.store(true, Ordering::Relaxed);
        beside
    });
    std::thread::sleep(Duration::from_secs(1));
    let alone = seconds_of_pings(&mut ben, 1_200);
    // Up to 400 messages are saved up, and 400 more are allowed each second.
    assert!(beside > 1.9 && alone < 0.5 * beside, "{beside} s beside a hand, {alone} s alone");
}

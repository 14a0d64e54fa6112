//! The loss of one client to another, in counts. `bendylights bench neighbours` measures times.

use std::io::Write;
use std::net::TcpStream;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use bench::neighbours::scenes;
use bench::{Client, Incoming};
use protocol::{ClientMessage, ErrorCode, ServerMessage, ViewSource};
use stream::FrameHeader;

use crate::sessions::support::{Mirror, Server, move_point, moved};

/// Requests a still of another session, whose scene takes minutes to draw, on a connection that is not read.
fn heavy_still(server: &Server, name: &str, scene: &[u8]) -> TcpStream {
    let uploaded = server.process.post(&format!("/assets?name={name}"), scene).expect("answered");
    let answer: serde_json::Value = serde_json::from_str(&uploaded.text()).expect("JSON");
    let notes = answer["notes"].to_string();
    assert!(notes.contains("take long"), "what it costs is named: {notes}");
    let session = format!(r#"{{"name": "{name}", "scene": {}}}"#, answer["asset"]);
    assert_eq!(server.process.post("/sessions", session.as_bytes()).expect("answered").status, 201);
    let host = &server.process.address.host;
    let mut stream = TcpStream::connect(host).expect("connected");
    let token = &server.process.address.token;
    let request = format!(
        "GET /sessions/{name}/render?size=64x36 HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\n\r\n"
    );
    stream.write_all(request.as_bytes()).expect("sent");
    stream
}

fn metric(server: &Server, name: &str) -> f64 {
    server.process.metric(&format!("bendylights_{name}"), "").expect("counted")
}

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + Duration::from_mins(1);
    while !is_so() {
        assert!(Instant::now() < until, "{what} never came");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// A still that the GPU or the CPU would draw for a minute in one piece yields in the middle while others draw, and
/// ends when its client disconnects.
///
/// Rules: HTTP-8, FRAME-16
#[test]
fn a_scene_that_takes_long_leaves_others_their_turns_and_ends_with_who_asked() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    ada.open_view();
    let (light, start) = (ada.light(), ada.point(2));
    let still = heavy_still(&server, "sheets", &scenes::triangles(64_000, "sheets"));
    wait_until("the still's first turn", || metric(&server, "still_turns_total") > 0.0);
    for step in 0..10 {
        let by = if step % 2 == 0 { 0.1 } else { -0.1 };
        let seq = ada.edited(move_point(light, 2, moved(start, [0.0, by, 0.0]))).seq().expect("committed");
        ada.receive_until("a frame", |incoming| match incoming {
            Incoming::Frame(header, _) if header.log_seq == seq => Some(()),
            _ => None,
        });
    }
    // The still is not finished: the edits above were drawn between its turns.
    let turns = metric(&server, "still_turns_total");
    wait_until("another turn of the still", || metric(&server, "still_turns_total") > turns);
    assert!(metric(&server, "least_still_turns") > 0.0);
    drop(still);
    wait_until("the end of the still", || metric(&server, "least_still_turns") == 0.0);
    let ended = metric(&server, "still_turns_total");
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!(metric(&server, "still_turns_total"), ended, "nobody waits for it any more");
}

/// Moves the cameras of all clients. Returns the latest moving frame of each, and the codes of the errors that they
/// got.
fn moving_frames(mirrors: &mut [Mirror], rounds: u32) -> (Vec<FrameHeader>, Vec<ErrorCode>) {
    let (mut latest, mut told) = (Vec::new(), Vec::new());
    for round in 1..=rounds {
        for mirror in mirrors.iter_mut() {
            let mut camera = mirror.client.welcome.camera.clone();
            camera.translation = moved(camera.translation, [0.001 * f64::from(round), 0.0, 0.0]);
            mirror.send(&ClientMessage::SetCamera { camera, camera_revision: 1 + round });
        }
        latest.clear();
        for mirror in mirrors.iter_mut() {
            latest.push(mirror.receive_until("a frame", |incoming| match incoming {
                Incoming::Frame(header, _) if header.camera_revision == 1 + round => Some(*header),
                Incoming::Message(message) => {
                    if let ServerMessage::Error { code, fatal: false, .. } = &**message {
                        told.push(*code);
                    }
                    None
                }
                Incoming::Frame(..) => None,
            }));
        }
    }
    (latest, told)
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
    let (frames, told) = moving_frames(&mut own, 5);
    let pixels = |frames: &[FrameHeader]| -> u64 {
        frames.iter().map(|header| u64::from(header.width) * u64::from(header.height)).sum()
    };
    assert!(pixels(&frames) <= 3840 * 2160, "{frames:?}");
    assert!(frames.iter().all(|header| [header.view_width, header.view_height].map(u32::from) == size));
    assert!(!told.is_empty() && told.len() <= 4, "each is told once: {told:?}");
    assert!(told.iter().all(|code| *code == ErrorCode::TooMany), "{told:?}");
    drop(own);
    let mut others: Vec<Mirror> = ["ben", "cyd", "dan", "eve"].map(open).into();
    let (frames, told) = moving_frames(&mut others, 2);
    assert!(pixels(&frames) == 4 * 1800 * 1200 && told.is_empty(), "{frames:?} {told:?}");
}

/// Rules: HTTP-9
#[test]
fn sessions_share_a_scene_on_the_device() {
    let server = Server::start();
    let kept = || server.process.metric("bendylights_render_bytes", "scenes").expect("counted");
    let mut ada = server.connect("ada");
    ada.open_view();
    ada.receive_until("a frame", |incoming| matches!(incoming, Incoming::Frame(..)).then_some(()));
    let before = kept();
    assert!(before > 0.0);
    let created = server.process.post("/sessions", br#"{"name": "second", "scene": "demo:vases"}"#);
    assert_eq!(created.expect("answered").status, 201);
    let mut ben = Client::connect(&server.process.address, "second", "ben", None).expect("welcome");
    let source = ViewSource::Own(ben.welcome.camera.clone());
    let (width, height, camera_revision, settings, interaction, stats) = (160, 90, 1, None, None, false);
    ben.send(&ClientMessage::OpenView {
        source,
        width,
        height,
        camera_revision,
        settings,
        interaction,
        stats,
    })
    .expect("sent");
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
    let last = |incoming: &Incoming| match incoming {
        Incoming::Message(message) => match **message {
            ServerMessage::Pong { sent, .. } => (sent == f64::from(count)).then_some(()),
            _ => None,
        },
        Incoming::Frame(..) => None,
    };
    client.wait_for("the last pong", |incoming| last(&incoming)).expect("answered");
    start.elapsed().as_secs_f64()
}

/// Messages that are read later are not lost. Without an interactive client they are read at once.
///
/// Rules: HTTP-28
#[test]
fn busy_senders_are_throttled_while_another_client_interacts() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    ada.open_view_of([160, 90], None);
    let mut ben = server.connect("ben").client;
    let is_over = AtomicBool::new(false);
    let (moves, moving) = mpsc::sync_channel(1);
    let beside = std::thread::scope(|scope| {
        let is_over = &is_over;
        scope.spawn(move || {
            let mut revision = 1;
            while !is_over.load(Ordering::Relaxed) {
                revision += 1;
                let mut camera = ada.client.welcome.camera.clone();
                camera.translation = moved(camera.translation, [0.001 * f64::from(revision), 0.0, 0.0]);
                ada.send(&ClientMessage::SetCamera { camera, camera_revision: revision });
                ada.receive_until("its frame", |incoming| match incoming {
                    Incoming::Frame(header, _) if header.camera_revision == revision => Some(()),
                    _ => None,
                });
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

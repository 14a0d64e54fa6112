//! Slow, silent and stalled clients keep nobody out, and the server does not wait for them forever.

use std::time::Duration;

use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};
use tokio::task::spawn_blocking;
use tokio::time::{Instant, pause, sleep, timeout};

use crate::client::{Client, HttpAnswer, ask_with, get, post};
use crate::server::{OwnServer, ServerDoor};

const SCENE: &[u8] = br#"{"asset": {"version": "2.0"}}"#;

/// Returns the head of a request, with the token.
fn head(door: &ServerDoor, request: &str, length: usize) -> String {
    let ServerDoor { address, token } = door;
    format!(
        "{request} HTTP/1.1\r\nHost: {address}\r\nAuthorization: Bearer {token}\r\nContent-Length: {length}\r\n\r\n"
    )
}

async fn send(door: &ServerDoor, text: &str) -> TcpStream {
    let mut stream = TcpStream::connect(door.address).await.unwrap();
    stream.write_all(text.as_bytes()).await.unwrap();
    stream
}

/// Returns everything that arrives until the server closes, and the time until then. Fails if it does not close.
async fn rest(stream: &mut TcpStream) -> (String, Duration) {
    let (began, mut text) = (Instant::now(), Vec::new());
    let read = timeout(Duration::from_hours(1), stream.read_to_end(&mut text));
    // A connection that is cut may be reset.
    let _ = read.await.expect("the server does not close");
    (String::from_utf8(text).unwrap(), began.elapsed())
}

/// Asks on another thread, since the server runs on this one.
async fn on_thread(
    door: &ServerDoor,
    ask: impl FnOnce(&ServerDoor) -> HttpAnswer + Send + 'static,
) -> HttpAnswer {
    let door = door.clone();
    spawn_blocking(move || ask(&door)).await.unwrap()
}

fn upload(door: &ServerDoor) -> HttpAnswer {
    ask_with(door, "/assets", &[("authorization", &format!("Bearer {}", door.token))], Some(SCENE))
}

/// Rules: HTTP-14
#[tokio::test]
async fn stalled_requests_keep_nobody_out_and_are_cut_off() {
    let own = OwnServer::start().await;
    let door = &own.door;
    let mut stalled = Vec::new();
    for _ in 0..3 {
        stalled.push(send(door, &(head(door, "POST /assets", 1_000) + "{")).await);
    }
    for _ in 0..70 {
        stalled.push(send(door, &(head(door, "POST /sessions", 1_000) + "{")).await);
    }
    let half_a_head = send(door, "GET /healthz HTTP/1.1\r\nHost: localhost\r\n").await;
    let nothing = send(door, "").await;
    let sent = on_thread(door, upload).await;
    assert_eq!(sent.status, 201, "{}", sent.text());
    let listed = on_thread(door, |door| get(door, "/sessions")).await;
    assert_eq!(listed.status, 200, "{}", listed.text());

    // From here on time advances once everybody waits.
    pause();
    for mut stream in [half_a_head, nothing] {
        let (answer, waited) = rest(&mut stream).await;
        assert!(answer.is_empty() && waited < Duration::from_secs(40), "{waited:?}: {answer}");
    }
    for mut stream in stalled {
        let (answer, waited) = rest(&mut stream).await;
        assert!(answer.starts_with("HTTP/1.1 408 ") && answer.contains("\"stalled\""), "{answer}");
        assert!(waited < Duration::from_secs(40), "{waited:?}");
    }
}

/// Rules: HTTP-14, HTTP-10
#[tokio::test]
async fn a_slow_upload_finishes() {
    let own = OwnServer::start().await;
    let door = &own.door;
    let mut slow = send(door, &head(door, "POST /assets", SCENE.len())).await;
    pause();
    let began = Instant::now();
    for byte in SCENE {
        sleep(Duration::from_secs(20)).await;
        slow.write_all(&[*byte]).await.unwrap();
    }
    assert!(began.elapsed() > Duration::from_mins(5));
    let mut status = [0; 12];
    slow.read_exact(&mut status).await.unwrap();
    assert_eq!(&status, b"HTTP/1.1 201");
}

/// Rules: HTTP-14, SOCK-10
#[tokio::test]
async fn who_takes_nothing_is_cut_off() {
    let own = OwnServer::start().await;
    let door = &own.door;
    // Records of 40 kB, because of their digits. 16 MB are more than the system buffers for this connection.
    let third = 1.0 / 3.0;
    let points: Vec<[f64; 3]> = (0..200).map(|k| [0.0, 0.0, -third * f64::from(k)]).collect();
    let (numbers, colors) = ([third; 200].to_vec(), [[third; 3]; 200].to_vec());
    let light = json!({"type": "bendy", "points": points, "radii": numbers, "colors": colors, "intensities": numbers});
    let mut edits = vec![json!({"command": {"type": "addLight", "light": light}})];
    for _ in 0..200 {
        edits.push(json!({"command": {"type": "insertPoint", "light": 1, "point": 100}}));
        edits.push(json!({"command": {"type": "removePoint", "light": 1, "point": 100}}));
    }
    let made = on_thread(door, |door| post(door, "/sessions", r#"{"name": "long"}"#));
    assert_eq!(made.await.status, 201);
    let (client, _) = Client::join_with_small_buffers(door, "long", "Ada").await;
    let edited = on_thread(door, move |door| {
        post(door, "/sessions/long/edits", &json!({ "edits": edits }).to_string())
    });
    assert_eq!(edited.await.status, 200);
    let log = on_thread(door, |door| get(door, "/sessions/long/log")).await.body;
    assert!(log.len() > 12 << 20, "{} bytes", log.len());

    let socket = TcpSocket::new_v4().unwrap();
    socket.set_recv_buffer_size(64 << 10).unwrap();
    let mut idle = socket.connect(door.address).await.unwrap();
    idle.write_all(head(door, "GET /sessions/long/log", 0).as_bytes()).await.unwrap();
    let clients = async || {
        let list = on_thread(door, |door| get(door, "/sessions")).await.json();
        list["sessions"]
            .as_array()
            .unwrap()
            .iter()
            .map(|session| session["clients"].as_u64().unwrap())
            .sum::<u64>()
    };
    assert_eq!(clients().await, 1);
    pause();
    sleep(Duration::from_secs(45)).await;
    assert_eq!(clients().await, 0, "a client is kept that takes nothing");
    drop(client);
    let (taken, _) = rest(&mut idle).await;
    assert!(!taken.is_empty() && taken.len() < log.len(), "{} of {} bytes came", taken.len(), log.len());
}

/// Rules: HTTP-14, SOCK-1
#[tokio::test]
async fn silent_connections_keep_nobody_out() {
    let own = OwnServer::start().await;
    let (mut sockets, mut silent) = (Vec::new(), Vec::new());
    for _ in 0..260 {
        sockets.push(Client::connect(&own.door).await);
    }
    for _ in 0..130 {
        silent.push(send(&own.door, "").await);
    }
    let (_ada, welcome) = Client::join(&own.door, "main", "Ada").await;
    assert_eq!(welcome.session, "main");
    assert_eq!(on_thread(&own.door, |door| get(door, "/sessions")).await.status, 200);
    drop((sockets, silent));
}

//! Slow, silent and stalled clients keep nobody out, and the server does not wait for them forever.

use std::time::Duration;

use serde_json::{Value, json};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, pause, sleep, timeout};

use crate::client::{
    Client, add_asset, connect_with_buffer, edit, get, head_of, insert_and_remove_point, large_light, make_session,
    on_thread, send_raw,
};
use crate::server::{OwnServer, ServerDoor};

const SCENE: &[u8] = br#"{"asset": {"version": "2.0"}}"#;

/// Returns the head of a request, with the token and the length of its body.
fn head(door: &ServerDoor, request: &str, length: usize) -> String {
    head_of(door, request, &format!("Content-Length: {length}"))
}

/// Returns everything that arrives until the server closes, and the time until then. Fails if it does not close.
async fn rest(stream: &mut TcpStream) -> (String, Duration) {
    let (began, mut text) = (Instant::now(), Vec::new());
    let read = timeout(Duration::from_hours(1), stream.read_to_end(&mut text));
    // A connection that is cut may be reset.
    let _ = read.await.expect("the server does not close");
    (String::from_utf8(text).unwrap(), began.elapsed())
}

/// Rules: HTTP-14
#[tokio::test]
async fn stalled_requests_keep_nobody_out_and_are_cut_off() {
    let own = OwnServer::start().await;
    let door = &own.door;
    let mut stalled = Vec::new();
    for (request, count) in [("POST /assets", 3), ("POST /sessions", 70)] {
        for _ in 0..count {
            stalled.push(send_raw(door, head(door, request, 1_000) + "{").await);
        }
    }
    let half_a_head = send_raw(door, "GET /healthz HTTP/1.1\r\nHost: localhost\r\n").await;
    let nothing = send_raw(door, "").await;
    on_thread(door, |door| add_asset(door, "", SCENE)).await;
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
    let mut slow = send_raw(door, head(door, "POST /assets", SCENE.len())).await;
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
async fn a_client_that_takes_nothing_is_cut_off() {
    let own = OwnServer::start().await;
    let door = &own.door;
    // 16 MB of records are more than the system buffers for this connection.
    let pairs = insert_and_remove_point().into_iter().cycle().take(400);
    let commands = std::iter::once(large_light()).chain(pairs);
    let edits: Vec<Value> = commands.map(|command| json!({ "command": command })).collect();
    on_thread(door, |door| make_session(door, &json!({"name": "long"}))).await;
    let (client, _) =
        Client::connect_with_small_buffers(door).await.greet(door, "long", "Ada").await.expect("a welcome");
    on_thread(door, move |door| edit(door, "long", &json!({ "edits": edits }))).await;
    let log = on_thread(door, |door| get(door, "/sessions/long/log")).await.body;
    assert!(log.len() > 12 << 20, "{} bytes", log.len());

    let mut idle = connect_with_buffer(door, 64 << 10).await;
    idle.write_all(head(door, "GET /sessions/long/log", 0).as_bytes()).await.unwrap();
    let clients = async || {
        let list = on_thread(door, |door| get(door, "/sessions")).await.json();
        list["sessions"].as_array().unwrap().iter().map(|session| session["clients"].as_u64().unwrap()).sum::<u64>()
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
        silent.push(send_raw(&own.door, "").await);
    }
    let (_ada, welcome) = Client::join(&own.door, "main", "Ada").await;
    assert_eq!(welcome.session, "main");
    assert_eq!(on_thread(&own.door, |door| get(door, "/sessions")).await.status, 200);
    drop((sockets, silent));
}

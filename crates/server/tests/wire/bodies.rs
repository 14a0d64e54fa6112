//! Bodies and answers in memory: they are limited by a budget, which is freed when they are cut off.

use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::spawn_blocking;
use tokio::time::sleep;

use crate::client::{HttpAnswer, bearer, get, post};
use crate::server::{OwnServer, ServerDoor};

const MIB: usize = 1 << 20;
/// Bytes that a body of 8 MiB reserves, and the number of such bodies that fit: half of the budget.
const COST: usize = 4 * 8 * MIB;
const ROOM: usize = 320 / 2 * MIB / COST;

async fn on_thread(
    door: &ServerDoor,
    ask: impl FnOnce(&ServerDoor) -> HttpAnswer + Send + 'static,
) -> HttpAnswer {
    let door = door.clone();
    spawn_blocking(move || ask(&door)).await.unwrap()
}

/// Returns the bytes that are reserved in the budget.
async fn held(door: &ServerDoor) -> usize {
    let metrics = on_thread(door, |door| get(door, "/metrics")).await;
    let line = metrics.text().lines().find_map(|line| line.strip_prefix("bendylights_bytes_in_flight "));
    line.expect("a count").parse().expect("a number")
}

/// Waits until the number of reserved bytes satisfies `wanted`.
async fn holds(door: &ServerDoor, wanted: impl Fn(usize) -> bool) {
    let mut tries = 0..1_000;
    while !wanted(held(door).await) {
        tries.next().expect("the account changes at once");
        sleep(Duration::from_millis(5)).await;
    }
}

/// Starts a request: its head, with a header for the length of its body, and a part of the body.
async fn begin(door: &ServerDoor, how: &str, part: &[u8]) -> TcpStream {
    let mut stream = TcpStream::connect(door.address).await.unwrap();
    let head = format!(
        "POST /sessions HTTP/1.1\r\nHost: localhost\r\nAuthorization: {}\r\nConnection: close\r\n{how}\r\n\r\n",
        bearer(door)
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    stream.write_all(part).await.unwrap();
    stream
}

fn session_of(name: &str, bytes: usize) -> String {
    let session = format!(r#"{{"name": "{name}"}}"#);
    let spaces = " ".repeat(bytes - session.len());
    session + &spaces
}

/// Rules: HTTP-26
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn bodies_that_are_cut_off_give_back_what_they_held() {
    let own = OwnServer::start().await;
    let door = &own.door;
    assert_eq!(held(door).await, 0);
    let said = format!("Content-Length: {}", 8 * MIB);
    let mut resting = Vec::new();
    for _ in 0..ROOM {
        resting.push(begin(door, &said, b"{").await);
    }
    holds(door, |held| held == ROOM * COST).await;
    // One byte of each has arrived, so the length in the head counts. A body of unknown length counts once it is large.
    let mut one_more = begin(door, &said, &vec![b' '; 8 * MIB]).await;
    let mut answer = String::new();
    one_more.read_to_string(&mut answer).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 503 ") && answer.contains("\"busy\""), "{answer}");
    assert!(answer.to_lowercase().contains("\r\nretry-after: 1\r\n"), "{answer}");
    let mut pieces = begin(door, "Transfer-Encoding: chunked", b"20000\r\n").await;
    pieces.write_all(&vec![b' '; 128 << 10]).await.unwrap();
    pieces.write_all(b"\r\n0\r\n\r\n").await.unwrap();
    answer.clear();
    pieces.read_to_string(&mut answer).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 503 "), "{answer}");
    let small = on_thread(door, |door| post(door, "/sessions", &session_of("small", 64 << 10))).await;
    assert_eq!(small.status, 201, "a small one is not refused for large ones: {}", small.text());
    let answer = on_thread(door, |door| get(door, "/openapi.json")).await;
    let is_large = answer.text().len() > 64 << 10;
    assert!(answer.status == 200 && is_large, "a large answer is not refused for bodies: {}", answer.status);
    // Far more than fit, all of which break off.
    for _ in 0..200 {
        resting.push(begin(door, &said, b"{").await);
    }
    assert!(held(door).await <= ROOM * COST);
    drop(resting);
    holds(door, |held| held == 0).await;
    let large = on_thread(door, |door| post(door, "/sessions", &session_of("large", 8 * MIB))).await;
    assert_eq!(large.status, 201, "{}", large.text());
    assert_eq!(held(door).await, 0, "what is answered holds nothing");
}

/// Rules: HTTP-14, HTTP-26
#[tokio::test]
async fn a_large_body_comes_within_two_minutes() {
    let own = OwnServer::start().await;
    let mut slow = begin(&own.door, &format!("Content-Length: {}", 8 * MIB), b"{").await;
    slow.write_all(&vec![b' '; 128 << 10]).await.unwrap();
    holds(&own.door, |held| held == COST).await;
    tokio::time::pause();
    for _ in 0..7 {
        sleep(Duration::from_secs(20)).await;
        // The server stops reading after its answer.
        let _ = slow.write_all(b" ").await;
    }
    let mut answer = vec![0; 12];
    slow.read_exact(&mut answer).await.unwrap();
    assert_eq!(answer, b"HTTP/1.1 408");
}

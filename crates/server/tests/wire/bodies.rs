//! Bodies and answers in memory: they are limited by a budget, which is freed when they are cut off.

use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::sleep;

use crate::client::{get, head_of, metric, on_thread, post, send_raw, wait_until};
use crate::server::{OwnServer, ServerDoor};

const MIB: usize = 1 << 20;
/// Bytes that a body of 8 MiB reserves, and the number of such bodies that fit: half of the budget.
const COST: usize = 4 * 8 * MIB;
const ROOM: usize = 320 / 2 * MIB / COST;

/// Returns the bytes that are reserved in the budget.
async fn reserved_bytes(door: &ServerDoor) -> usize {
    on_thread(door, |door| metric(door, "bendylights_bytes_in_flight")).await.expect("a count") as usize
}

/// Waits until the number of reserved bytes satisfies `wanted`.
async fn until_reserved(door: &ServerDoor, wanted: impl Fn(usize) -> bool) {
    wait_until("the budget changes at once", async || wanted(reserved_bytes(door).await)).await;
}

/// Starts a request: its head, with a header for the length of its body, and a part of the body.
async fn begin(door: &ServerDoor, length: &str, part: &[u8]) -> TcpStream {
    let head = head_of(door, "POST /sessions", &format!("Connection: close\r\n{length}"));
    send_raw(door, [head.as_bytes(), part].concat()).await
}

fn session_of(name: &str, bytes: usize) -> String {
    let session = format!(r#"{{"name": "{name}"}}"#);
    let spaces = " ".repeat(bytes - session.len());
    session + &spaces
}

/// Rules: HTTP-26
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn bodies_that_are_cut_off_free_their_reservation() {
    let own = OwnServer::start().await;
    let door = &own.door;
    assert_eq!(reserved_bytes(door).await, 0);
    let length = format!("Content-Length: {}", 8 * MIB);
    let mut resting = Vec::new();
    for _ in 0..ROOM {
        resting.push(begin(door, &length, b"{").await);
    }
    until_reserved(door, |bytes| bytes == ROOM * COST).await;
    // One byte of each has arrived, so the length in the head counts. A body of unknown length counts once it is large.
    let mut one_more = begin(door, &length, &vec![b' '; 8 * MIB]).await;
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
        resting.push(begin(door, &length, b"{").await);
    }
    assert!(reserved_bytes(door).await <= ROOM * COST);
    drop(resting);
    until_reserved(door, |bytes| bytes == 0).await;
    let large = on_thread(door, |door| post(door, "/sessions", &session_of("large", 8 * MIB))).await;
    assert_eq!(large.status, 201, "{}", large.text());
    assert_eq!(reserved_bytes(door).await, 0, "what is answered holds nothing");
}

/// Rules: HTTP-14, HTTP-26
#[tokio::test]
async fn a_large_body_comes_within_two_minutes() {
    let own = OwnServer::start().await;
    let mut slow = begin(&own.door, &format!("Content-Length: {}", 8 * MIB), b"{").await;
    slow.write_all(&vec![b' '; 128 << 10]).await.unwrap();
    until_reserved(&own.door, |bytes| bytes == COST).await;
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

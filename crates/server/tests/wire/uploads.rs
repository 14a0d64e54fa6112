//! Uploads of scenes that fail: cut off, or too large.

use std::fs;
use std::path::Path;
use std::time::Duration;

use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::spawn_blocking;
use tokio::time::sleep;

use crate::client::{ask_with, bearer};
use crate::server::{OwnServer, ServerDoor};

const MIB: usize = 1 << 20;
/// More than the server receives at once.
const MANY: usize = 40;

/// Starts to upload a scene of that many bytes by its head.
async fn begin(door: &ServerDoor, bytes: usize, part: &[u8]) -> TcpStream {
    let mut stream = TcpStream::connect(door.address).await.unwrap();
    let head = format!(
        "POST /assets?name=large HTTP/1.1\r\nHost: localhost\r\nAuthorization: {}\r\nContent-Length: {bytes}\r\n\r\n",
        bearer(door)
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    stream.write_all(part).await.unwrap();
    stream
}

/// Returns the size and number of the unnamed files in the folder that this process, which is the server, has open.
fn unnamed(folder: &Path) -> (u64, usize) {
    let open = fs::read_dir("/proc/self/fd").unwrap().filter_map(Result::ok).filter(|entry| {
        let target = fs::read_link(entry.path()).unwrap_or_default();
        target.starts_with(folder) && target.to_string_lossy().ends_with("(deleted)")
    });
    let sizes: Vec<u64> = open.filter_map(|entry| Some(fs::metadata(entry.path()).ok()?.len())).collect();
    (sizes.iter().sum(), sizes.len())
}

/// Returns the named files in the folder, except for those of the log.
fn named(folder: &Path) -> Vec<String> {
    let mut names = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if !path.to_string_lossy().contains(".sqlite") {
                names.push(path.to_string_lossy().into_owned());
            }
        }
    }
    names.sort();
    names
}

async fn until(what: &str, holds: impl Fn() -> bool) {
    let mut tries = 0..1_000;
    while !holds() {
        assert!(tries.next().is_some(), "{what}");
        sleep(Duration::from_millis(5)).await;
    }
}

/// An upload of 500 MB that is cut off leaves nothing on disk, and its permit is free again.
///
/// Rules: HTTP-10
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_cut_off_leaves_nothing() {
    let own = OwnServer::start().await;
    let folder = own.folder.path().canonicalize().unwrap();
    let before = named(&folder);
    let part = vec![b' '; 8 * MIB];
    for _ in 0..MANY {
        let sending = begin(&own.door, 500 * MIB, &part).await;
        // Deliberate fault that the check must detect: while it arrives, it is there.
        until("what has come is on the disk", || unnamed(&folder).0 == part.len() as u64).await;
        assert_eq!(named(&folder), before, "what is on its way has no name");
        drop(sending);
        until("what was cut off is gone", || unnamed(&folder) == (0, 0)).await;
    }
    assert_eq!(named(&folder), before);
    let door = own.door.clone();
    let scene = json!({"asset": {"version": "2.0"}, "nodes": [{"name": "n"}]}).to_string();
    let send =
        move || ask_with(&door, "/assets", &[("authorization", &bearer(&door))], Some(scene.as_bytes()));
    assert_eq!(spawn_blocking(send).await.unwrap().status, 201, "all turns are free");
    assert_eq!(named(&folder).len(), before.len() + 1, "one that arrives is kept");
}

/// A body that is too large by its head is refused before any of it arrives.
///
/// Rules: HTTP-11
#[tokio::test]
async fn what_is_too_large_is_refused_at_once() {
    let own = OwnServer::start().await;
    let mut sending = begin(&own.door, 769 * MIB, b"glTF").await;
    let mut answer = vec![0; 1024];
    let length = sending.read(&mut answer).await.unwrap();
    let answer = String::from_utf8_lossy(&answer[..length]);
    assert!(answer.starts_with("HTTP/1.1 413 ") && answer.contains("tooLarge"), "{answer}");
    assert!(answer.contains(&(768 * MIB).to_string()), "{answer}");
    // A body of the greatest size is waited for.
    let mut fits = begin(&own.door, 768 * MIB, b"glTF").await;
    let waits = tokio::time::timeout(Duration::from_millis(200), fits.read(&mut [0; 16])).await;
    assert!(waits.is_err(), "{waits:?}");
}

//! Uploads of scenes that fail: cut off, or too large.

use std::fs;
use std::path::Path;
use std::time::Duration;

use serde_json::json;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;

use crate::client::{head_of, on_thread, send_raw, upload, wait_until};
use crate::server::{OwnServer, ServerDoor};

const MIB: usize = 1 << 20;
/// More than the server receives at once.
const MANY: usize = 40;

/// Starts to upload a scene of that many bytes by its head.
async fn begin(door: &ServerDoor, bytes: usize, part: &[u8]) -> TcpStream {
    let head = head_of(door, "POST /assets?name=large", &format!("Content-Length: {bytes}"));
    send_raw(door, [head.as_bytes(), part].concat()).await
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

/// An upload of 500 MB that is cut off leaves nothing on disk, and its permit is free again.
///
/// Rules: HTTP-10
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_upload_that_is_cut_off_leaves_nothing() {
    let own = OwnServer::start().await;
    let folder = own.folder.path().canonicalize().unwrap();
    let before = named(&folder);
    let part = vec![b' '; 8 * MIB];
    for _ in 0..MANY {
        let sending = begin(&own.door, 500 * MIB, &part).await;
        // Deliberate fault that the check must detect: while it arrives, it is there.
        wait_until("received bytes are on the disk", async || unnamed(&folder).0 == part.len() as u64).await;
        assert_eq!(named(&folder), before, "what is on its way has no name");
        drop(sending);
        wait_until("a file that was cut off is gone", async || unnamed(&folder) == (0, 0)).await;
    }
    assert_eq!(named(&folder), before);
    let scene = json!({"asset": {"version": "2.0"}, "nodes": [{"name": "n"}]}).to_string();
    let sent = on_thread(&own.door, move |door| upload(door, "", scene.as_bytes())).await;
    assert_eq!(sent.status, 201, "all permits are free");
    assert_eq!(named(&folder).len(), before.len() + 1, "one that arrives is kept");
}

/// A body that is too large by its head is refused before any of it arrives.
///
/// Rules: HTTP-11
#[tokio::test]
async fn an_upload_that_is_too_large_is_refused_at_once() {
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

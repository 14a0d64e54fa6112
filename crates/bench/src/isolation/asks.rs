//! Actions over HTTP, and probes: stills, uploads, requests without pictures, edits.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use protocol::{ClientMessage, ServerMessage};
use serde_json::{Value, json};

use super::other::{ClientAction, OtherClient, POLL_INTERVAL, Writes};
use super::setup::{SIZE, document, first_light, make_session, post, rename};
use super::{scenes, usage};
use crate::{BenchError, Incoming};

/// Numbers of triangles and of primitives at one position.
const TRIANGLES: [u32; 2] = [16_000, 64_000];
const PRIMITIVES: usize = 100_000;
/// Concurrent requests for stills, as many as a server accepts.
const STILLS: usize = 8;
/// Number of concurrent clients that edit.
const EDITORS: usize = 8;
/// Bytes of an actor's name, the most that a server accepts.
const LABEL_BYTES: usize = 128;
/// Number of drags in one request.
const DRAGS: usize = 8;

/// Requests stills of a scene with all geometry at one position.
pub(super) fn stills(other: &OtherClient, scene: &[u8]) -> Result<ClientAction, BenchError> {
    let answer = other.address.post("/assets", scene)?;
    let uploaded: Value = serde_json::from_slice(&answer.body).unwrap_or_default();
    let Some(asset) = uploaded["asset"].as_str() else { return Err(BenchError::Refused(answer.text())) };
    make_session(&other.address, &other.session(0), asset)?;
    Ok(Box::new(|other| {
        for _ in 0..STILLS {
            other.spawn(|other| {
                let path = format!("/sessions/{}/render?size=64x36", other.session(0));
                other.ask("GET", &path, b"")
            });
        }
        Ok(())
    }))
}

/// Uploads files, each a different one.
#[expect(clippy::unnecessary_wraps, reason = "rows are prepared alike")]
pub(super) fn imports(_: &OtherClient) -> Result<ClientAction, BenchError> {
    let [few, many] = TRIANGLES.map(|count| scenes::triangles(count, &upload_name(0, 0)));
    let files = Arc::new([few, many, scenes::primitives(PRIMITIVES, &upload_name(0, 0))]);
    Ok(Box::new(move |other| {
        for thread in 0..2 {
            let (files, mut count) = (Arc::clone(&files), 0);
            other.spawn(move |other| {
                count += 1;
                let file = &files[count % files.len()];
                other.ask("POST", "/assets", &renamed(file, &upload_name(0, 0), &upload_name(thread, count)))
            });
        }
        Ok(())
    }))
}

/// Returns the name of an upload. All names have the same length.
fn upload_name(thread: usize, count: usize) -> String {
    format!("upload {thread} {count:08}")
}

/// Replaces a name in a file by one of the same length. The server sees a different file, and making it takes hardly
/// any time.
fn renamed(file: &[u8], from: &str, to: &str) -> Vec<u8> {
    let at = file.windows(from.len()).position(|bytes| bytes == from.as_bytes());
    let mut renamed = file.to_vec();
    if let Some(at) = at {
        renamed[at..at + from.len()].copy_from_slice(to.as_bytes());
    }
    renamed
}

/// Makes every kind of request that is answered without a picture. Each has a thread that requests again after each
/// answer.
pub(super) fn ask_without_pictures(other: &OtherClient) -> Result<ClientAction, BenchError> {
    let session = other.session(0);
    make_session(&other.address, &session, "demo:vases")?;
    let camera = &document(&other.address, &session)?["cameras"][0]["camera"];
    let pixel = [f64::from(SIZE[0]) / 2.0, f64::from(SIZE[1]) / 2.0];
    let drag = json!({
        "light": 0, "kind": "hotspot", "size": SIZE, "from": pixel, "to": [pixel[0] + 20.0, pixel[1]], "pins": [],
    });
    let requests = [
        ("GET", "/openapi.json".to_owned(), Value::Null),
        ("GET", format!("/sessions/{session}"), Value::Null),
        ("POST", format!("/sessions/{session}/pick"), json!({"camera": camera})),
        ("POST", format!("/sessions/{session}/probe"), json!({"size": SIZE, "pixel": pixel})),
        ("POST", format!("/sessions/{session}/drags"), json!(vec![drag; DRAGS])),
    ];
    Ok(Box::new(move |other| {
        for (method, path, body) in requests {
            let body = if body.is_null() { String::new() } else { body.to_string() };
            other.spawn(move |other| other.ask(method, &path, body.as_bytes()));
        }
        other.spawn(move |other| probe(other, pixel));
        Ok(())
    }))
}

/// Probes on a socket, one after the other.
fn probe(other: &OtherClient, pixel: [f64; 2]) -> Result<(), BenchError> {
    let mut client = other.connect(0)?;
    while !other.is_over() {
        let probe = "probe".to_owned();
        let message = ClientMessage::Probe { probe, pixel, camera: None, size: Some(SIZE), highlights: false };
        client.send(&message)?;
        other.count_done(1);
        while !other.is_over() {
            let message = client.receive(POLL_INTERVAL)?.and_then(Incoming::into_message);
            if let Some(ServerMessage::Probed(_) | ServerMessage::Error { .. }) = message {
                other.count_answered(1);
                break;
            }
        }
    }
    Ok(())
}

/// Edits as one actor for half of the time, then as a new actor for each edit, and measures the bytes written per edit.
pub(super) fn edit_as_many_actors(other: &OtherClient) -> Result<ClientAction, BenchError> {
    let session = other.session(0);
    make_session(&other.address, &session, "demo:vases")?;
    let light = first_light(&other.address, &session)?;
    // The first edit opens the session.
    post(&other.address, &format!("/sessions/{session}/edits"), &edit_of(light, "first", 0))?;
    Ok(Box::new(move |other| {
        let (count, are_many) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        for _ in 0..EDITORS {
            let (count, are_many) = (count.clone(), are_many.clone());
            other.spawn(move |other| {
                let n = count.load(Ordering::Relaxed);
                let id = format!("{:0>LABEL_BYTES$x}", fastrand::u64(..));
                let actor = if are_many.load(Ordering::Relaxed) { &id } else { "one" };
                let body = edit_of(light, actor, n).to_string();
                other.ask("POST", &format!("/sessions/{}/edits", other.session(0)), body.as_bytes())?;
                count.fetch_add(1, Ordering::Relaxed);
                Ok(())
            });
        }
        other.spawn(move |other| {
            let measure = || -> Result<f64, BenchError> {
                let (written, edits) = (usage::written_bytes(other.pid)?, count.load(Ordering::Relaxed));
                other.wait(other.span.mul_f64(0.45));
                let bytes = usage::written_bytes(other.pid)?.saturating_sub(written);
                Ok(bytes as f64 / count.load(Ordering::Relaxed).saturating_sub(edits) as f64)
            };
            let one_actor_bytes = measure()?;
            are_many.store(true, Ordering::Relaxed);
            let many_actors_bytes = measure()?;
            // Nothing is written if the file system is in memory.
            if one_actor_bytes > 0.0 {
                let ratio = many_actors_bytes / one_actor_bytes;
                other.keep_writes(Writes { one_actor_bytes, many_actors_bytes, ratio });
            }
            other.wait_until_over();
            Ok(())
        });
        Ok(())
    }))
}

fn edit_of(light: u64, actor: &str, n: u64) -> Value {
    json!({"actor": {"id": actor, "name": actor}, "edits": [{"command": rename(light, n)}]})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_upload_is_another_file_that_is_read() {
        let file = scenes::triangles(2, &upload_name(0, 0));
        let renamed = renamed(&file, &upload_name(0, 0), &upload_name(1, 7));
        assert_eq!(assets::load_bytes(&renamed).expect("a scene").name, Some(upload_name(1, 7)));
    }
}

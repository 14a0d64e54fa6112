//! Actions that make the server hold memory: answers that are not read, and bodies that never end.

use std::io::Write;
use std::net::{Shutdown, TcpStream};
use std::sync::Arc;
use std::time::Duration;

use serde_json::{Value, json};

use super::other::{CLIENTS, ClientAction, OtherClient};
use super::setup::{edit, make_session};
use crate::BenchError;
use crate::client::say_hello;

/// Number of lights in a large document, the most that a document may have. The next constant is the number of control
/// points of each.
const LIGHTS: usize = 250;
const POINTS: usize = 258;
/// Number of link paths of each light. The next constant is the length of each path in bytes. Together with its control
/// points a light has some 70 KB.
const PATHS: usize = 100;
const PATH_BYTES: usize = 300;
/// Number of requests, and of sockets, that read nothing.
const READERS: usize = CLIENTS;
/// Number of bodies that lack their last byte, and the size that each declares.
const BODIES: usize = 200;
const BODY_BYTES: usize = 8 << 20;
const SENDERS: usize = 4;
/// Time for which the bodies are held before their connections are closed.
const HELD: Duration = Duration::from_secs(2);

/// Opens sockets and requests for a document of 16 MiB, and reads nothing.
pub(super) fn reads_nothing(other: &OtherClient) -> Result<ClientAction, BenchError> {
    let session = other.session(0);
    make_session(&other.address, &session, "demo:vases")?;
    for number in (0..LIGHTS).step_by(50) {
        let lights: Vec<Value> =
            (number..number + 50).map(|n| json!({"type": "addLight", "light": heavy_light(n)})).collect();
        edit(&other.address, &session, &other.actor(0), &lights)?;
    }
    Ok(Box::new(|other| {
        other.spawn(|other| {
            let (mut sockets, mut requests) = (Vec::new(), Vec::new());
            let path = format!("/sessions/{}", other.session(0));
            for reader in (0..READERS).take_while(|_| !other.is_over()) {
                let opened = (|| {
                    let session = other.session(0);
                    let actor = other.actor(reader);
                    sockets.push(say_hello(other.tcp()?, &other.address, &session, &actor, None)?);
                    requests.push(other.send_request("GET", &path, b"")?);
                    other.count_done(2);
                    Ok(())
                })();
                other.count_refusal(opened);
            }
            other.wait_until_over();
            Ok(())
        });
        Ok(())
    }))
}

/// Returns a BendyLight of the maximum number of bytes, switched off.
fn heavy_light(number: usize) -> Value {
    let mut rng = fastrand::Rng::with_seed(number as u64);
    let points: Vec<[f64; 3]> =
        (0..POINTS)
            .map(|k| {
                if k == 0 {
                    [0.0; 3]
                } else {
                    [1e-6 * rng.f64(), 1e-6 * rng.f64(), -0.1 * (k as f64 + 1e-3 * rng.f64())]
                }
            })
            .collect();
    let radii: Vec<f64> = (0..POINTS).map(|_| 1e-3 * rng.f64()).collect();
    let colors: Vec<[f64; 3]> = (0..POINTS).map(|_| [rng.f64(), rng.f64(), rng.f64()]).collect();
    let intensities: Vec<f64> = (0..POINTS).map(|_| rng.f64()).collect();
    let paths: Vec<String> = (0..PATHS).map(|k| format!("{k}-{}", "x".repeat(PATH_BYTES))).collect();
    json!({
        "type": "bendy", "name": format!("heavy {number}"), "enabled": false,
        "points": points, "radii": radii, "colors": colors, "intensities": intensities,
        "lightLink": {"include": paths},
    })
}

/// Sends many bodies at once, each without its last byte.
pub(super) fn cut_bodies(other: &OtherClient) -> Result<ClientAction, BenchError> {
    make_session(&other.address, &other.session(0), "demo:vases")?;
    Ok(Box::new(|other| {
        let body = Arc::new(vec![b' '; BODY_BYTES - 1]);
        for _ in 0..SENDERS {
            let body = body.clone();
            other.spawn(move |other| {
                let mut held: Vec<TcpStream> = Vec::new();
                for _ in (0..BODIES / SENDERS).take_while(|_| !other.is_over()) {
                    match send_all_but_the_last(other, &body) {
                        Ok(connection) => held.push(connection),
                        Err(why) => other.count_refusal(Err(why)),
                    }
                }
                other.wait(HELD);
                other.count_done(held.len() as u64);
                for connection in held {
                    let _ = connection.shutdown(Shutdown::Both);
                }
                Ok(())
            });
        }
        Ok(())
    }))
}

fn send_all_but_the_last(other: &OtherClient, body: &[u8]) -> Result<TcpStream, BenchError> {
    let mut tcp = other.tcp()?;
    tcp.set_write_timeout(Some(HELD))?;
    let path = format!("/sessions/{}/edits", other.session(0));
    tcp.write_all(other.head("POST", &path, BODY_BYTES).as_bytes())?;
    tcp.write_all(body)?;
    Ok(tcp)
}

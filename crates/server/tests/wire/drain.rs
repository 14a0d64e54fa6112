//! Stopping the server.

use std::time::Duration;

use light::parameters::CONE_ANGLE;
use protocol::{Command, ServerMessage};
use serde_json::json;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::spawn_blocking;
use tokio::time::{Instant, pause, sleep};

use crate::client::{Client, get, head_of, on_thread, post_edits, send_raw, state};
use crate::server::OwnServer;

/// Rules: SOCK-9, HTTP-9
#[tokio::test]
async fn a_server_that_stops_finishes_what_it_has_accepted() {
    let own = OwnServer::start().await;
    let (mut client, welcome) = Client::join(&own.door, "main", "Ada").await;
    for step in 0..10 {
        let parameter = CONE_ANGLE.to(20.0 + f64::from(step)).into();
        let command = Command::SetLight { light: 1, parameter, ignore_pins: false };
        client.say_edit(&format!("edit {step}"), welcome.seq, command).await;
    }
    client.outcome("edit 0").await;
    let token = own.door.token.clone();
    let (folder, served) = own.stop();

    let (mut committed, mut was_told) = (1, false);
    while let Some(message) = client.next().await {
        match message {
            ServerMessage::EditResult(result) if result.outcome.seq().is_some() => committed += 1,
            ServerMessage::Draining { retry_after_ms } => was_told = retry_after_ms > 0,
            _ => {}
        }
    }
    assert!(was_told, "the client was not told");
    served.await.unwrap().unwrap();

    // The folder is unlocked, pages stay signed in, and acknowledged records are there.
    let again = OwnServer::start_in(folder).await;
    assert_eq!(again.door.token, token);
    let session = on_thread(&again.door, |door| state(door, "main")).await;
    assert!(session["seq"].as_u64().unwrap() >= welcome.seq + committed, "{committed} and {session}");
}

/// Rules: SOCK-9
#[tokio::test]
async fn connections_that_ask_for_nothing_do_not_hold_up_a_stop() {
    let own = OwnServer::start().await;
    let mut silent = Vec::new();
    for begun in ["", "GET /hea", "GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n"] {
        silent.push(send_raw(&own.door, begun).await);
    }
    // The last one is answered and kept open. The others are accepted by then too.
    silent[2].read_exact(&mut [0; 12]).await.unwrap();
    // From here on time advances once everybody waits.
    pause();
    let stopped = Instant::now();
    let (_folder, served) = own.stop();
    served.await.unwrap().unwrap();
    assert!(stopped.elapsed() < Duration::from_secs(5), "{:?}", stopped.elapsed());
}

/// Rules: HTTP-9
#[tokio::test]
async fn a_request_during_draining_is_refused_as_such() {
    let own = OwnServer::start().await;
    // A request whose body has not arrived is waited for.
    let body = r#"{"name": "late"}"#;
    let head = head_of(&own.door, "POST /sessions", &format!("Content-Length: {}", body.len()));
    let mut slow = send_raw(&own.door, head + &body[..5]).await;
    sleep(Duration::from_millis(300)).await;
    let (door, address) = (own.door.clone(), own.door.address);
    let (_folder, served) = own.stop();
    let asked = spawn_blocking(move || {
        let ready = loop {
            let answer = get(&door, "/readyz");
            if answer.status != 200 {
                break answer;
            }
        };
        assert_eq!(ready.refusal(), (503, "draining".into()));
        assert_eq!(get(&door, "/healthz").status, 200, "it still runs");
        let edit = post_edits(&door, "main", &json!({"edits": [{"undo": "mine"}]}));
        assert_eq!(edit.refusal(), (503, "draining".into()));
    });
    asked.await.unwrap();
    assert!(!served.is_finished(), "it waits for the body");
    slow.write_all(&body.as_bytes()[5..]).await.unwrap();
    let mut answer = String::new();
    slow.read_to_string(&mut answer).await.unwrap();
    assert!(answer.starts_with("HTTP/1.1 "), "{answer}");
    served.await.unwrap().unwrap();
    assert!(TcpStream::connect(address).await.is_err(), "nobody listens");
}

/// A picture that is not finished in time is refused like a late request. It is no fault of the server.
///
/// Rules: SOCK-9, HTTP-9
#[tokio::test]
async fn a_picture_that_a_stop_cuts_short_is_refused_as_draining() {
    let own = OwnServer::start().await;
    let door = own.door.clone();
    let picture = spawn_blocking(move || get(&door, "/sessions/main/render?size=4096x4096&samples=64"));
    sleep(Duration::from_millis(500)).await;
    let (_folder, served) = own.stop();
    assert_eq!(picture.await.unwrap().refusal(), (503, "draining".into()));
    served.await.unwrap().unwrap();
}

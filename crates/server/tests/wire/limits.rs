//! Requests that are too large or too many.

use std::time::Duration;

use protocol::{ClientMessage, ErrorCode, ServerMessage, ViewSource};
use serde_json::json;
use tokio::task::spawn_blocking;
use tokio::time::sleep;

use crate::client::{Client, ReceivedMessage, get, hello, new_session, post};
use crate::hello::complaint;
use crate::server::{OwnServer, SHARED};

/// Rules: HTTP-11
#[test]
fn what_is_too_large_is_refused_with_the_limit() {
    let too_large = |answer: crate::client::HttpAnswer, limit: &str| {
        assert_eq!(answer.refusal(), (413, "tooLarge".into()));
        assert!(answer.text().contains(limit), "{} does not name {limit}", answer.text());
    };
    too_large(get(&SHARED, "/sessions/main/render?size=4097x2"), "4096");
    too_large(get(&SHARED, "/sessions/main/render?samples=65"), "64");
    too_large(get(&SHARED, "/sessions/main/log?limit=10001"), "10000");
    too_large(post(&SHARED, "/sessions", &" ".repeat((8 << 20) + 1)), "8388608");
    let edits = vec![r#"{"undo": "mine"}"#; 1_001].join(",");
    too_large(post(&SHARED, "/sessions/main/edits", &format!(r#"{{"edits": [{edits}]}}"#)), "1000");
    let named = format!(r#"{{"edits": [{{"opId": "{}", "undo": "mine"}}]}}"#, "x".repeat(129));
    too_large(post(&SHARED, "/sessions/main/edits", &named), "128");
}

/// Rules: HTTP-11
#[tokio::test]
async fn a_client_is_told_the_limits_of_views_and_messages() {
    let (mut client, welcome) = Client::join(&SHARED, "main", "Mia").await;
    let side = welcome.settings.max_view_side;
    let open = |width, height| ClientMessage::OpenView {
        source: ViewSource::Own(welcome.camera.clone()),
        width,
        height,
        camera_revision: 1,
        settings: None,
        interaction: None,
        stats: false,
    };
    for view in [open(side + 1, 2), open(2, side + 1), open(side, side)] {
        client.say(&view).await;
        assert_eq!(client.until(complaint).await.0, "tooLarge");
    }
    client.say(&open(0, 2)).await;
    assert_eq!(client.until(complaint).await.0, "badMessage");
    client.say_text(format!(r#"{{"type": "ping", "sent": 1{}}}"#, " ".repeat(1 << 20))).await;
    let (code, sentence) = client.until(complaint).await;
    assert!(code == "tooLarge" && sentence.contains("1048576"), "{code}: {sentence}");
}

/// Rules: HTTP-5, HTTP-12
#[test]
fn sessions_that_nobody_is_in_make_room() {
    // More than are open at once.
    let names: Vec<String> = (0..72).map(|number| format!("unattended-{number}")).collect();
    for name in &names {
        let made = post(&SHARED, "/sessions", &json!({ "name": name }).to_string());
        assert_eq!(made.status, 201, "{name}: {}", made.text());
        let edits =
            json!({"edits": [{"command": {"type": "addLight", "light": {"type": "spot", "name": name}}}]});
        assert_eq!(post(&SHARED, &format!("/sessions/{name}/edits"), &edits.to_string()).status, 200);
    }
    for name in &names {
        let session = get(&SHARED, &format!("/sessions/{name}"));
        assert_eq!(session.status, 200, "{name}: {}", session.text());
        let light = &session.json()["document"]["lights"][0]["light"];
        assert_eq!(light["name"], name.as_str(), "what was done is there when it is opened again");
    }
}

/// Rules: HTTP-12
#[tokio::test]
async fn sessions_with_somebody_in_them_stay_open() {
    let own = OwnServer::start().await;
    let mut people = Vec::new();
    for number in 0..64 {
        let (door, name) = (own.door.clone(), format!("attended-{number}"));
        let body = json!({ "name": name }).to_string();
        let made = spawn_blocking(move || post(&door, "/sessions", &body)).await.unwrap();
        assert_eq!(made.status, 201, "{}", made.text());
        people.push(Client::join(&own.door, &name, "Ada").await.0);
    }
    let look = || {
        let door = own.door.clone();
        spawn_blocking(move || get(&door, "/sessions/main"))
    };
    let refused = look().await.unwrap();
    assert_eq!(refused.refusal(), (429, "tooMany".into()));
    assert!(refused.text().contains("64"), "{}", refused.text());
    drop(people.pop());
    // The server takes a moment to notice that a client has left.
    let mut tries = 0..1_000;
    while look().await.unwrap().status == 429 {
        tries.next().expect("whoever leaves makes room at once, not after a minute");
        sleep(Duration::from_millis(5)).await;
    }
}

/// Rules: HTTP-11
#[tokio::test]
async fn a_session_has_room_for_so_many_and_says_when_it_is_full() {
    new_session(&SHARED, "crowd");
    let mut crowd = Vec::new();
    for number in 0..64 {
        crowd.push(Client::join(&SHARED, "crowd", &format!("client {number}")).await.0);
    }
    let mut late = Client::connect(&SHARED).await;
    late.say(&hello(&SHARED.token, "crowd", "Late")).await;
    match late.next().await {
        ReceivedMessage::Control(ServerMessage::Error { code, message, fatal: true }) => {
            assert!(code == ErrorCode::TooMany && message.contains("64"), "{code}: {message}");
        }
        other => panic!("not refused but {other:?}"),
    }
}

//! Requests that are too large or too many.

use protocol::{ErrorCode, ViewSource};
use serde_json::json;

use crate::client::{
    Client, HttpAnswer, edit, get, make_session, new_session, on_thread, open_view, post, post_edits, spot, wait_until,
};
use crate::hello::complaint;
use crate::server::{OwnServer, SHARED};

/// Rules: HTTP-11
#[test]
fn a_large_request_is_refused_with_the_limit() {
    let too_large = |answer: HttpAnswer, limit: &str| {
        assert_eq!(answer.refusal(), (413, "tooLarge".into()));
        assert!(answer.text().contains(limit), "{} does not name {limit}", answer.text());
    };
    too_large(get(&SHARED, "/sessions/main/render?size=4097x2"), "4096");
    too_large(get(&SHARED, "/sessions/main/render?samples=65"), "64");
    too_large(get(&SHARED, "/sessions/main/log?limit=10001"), "10000");
    too_large(post(&SHARED, "/sessions", &" ".repeat((8 << 20) + 1)), "8388608");
    let edits = json!({"edits": vec![json!({"undo": "mine"}); 1_001]});
    too_large(post_edits(&SHARED, "main", &edits), "1000");
    let named = json!({"edits": [{"opId": "x".repeat(129), "undo": "mine"}]});
    too_large(post_edits(&SHARED, "main", &named), "128");
}

/// Rules: HTTP-11
#[tokio::test]
async fn a_client_is_told_the_limits_of_views_and_messages() {
    let (mut client, welcome) = Client::join(&SHARED, "main", "Mia").await;
    let side = welcome.settings.max_view_side;
    let open = |width, height| open_view(ViewSource::Own(welcome.camera.clone()), [width, height]);
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
        make_session(&SHARED, &json!({ "name": name }));
        edit(&SHARED, name, &json!({"edits": [{"command": spot(name)}]}));
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
        let name = format!("attended-{number}");
        let session = json!({ "name": name });
        on_thread(&own.door, move |door| make_session(door, &session)).await;
        people.push(Client::join(&own.door, &name, "Ada").await.0);
    }
    let look = || on_thread(&own.door, |door| get(door, "/sessions/main"));
    let refused = look().await;
    assert_eq!(refused.refusal(), (429, "tooMany".into()));
    assert!(refused.text().contains("64"), "{}", refused.text());
    drop(people.pop());
    // The server takes a moment to notice that a client has left.
    let what = "a client that leaves makes room at once, not after a minute";
    wait_until(what, async || look().await.status != 429).await;
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
    late.say_hello(&SHARED, "crowd", "Late").await;
    let (code, message) = late.fatal_error().await;
    assert!(code == ErrorCode::TooMany && message.contains("64"), "{code}: {message}");
}

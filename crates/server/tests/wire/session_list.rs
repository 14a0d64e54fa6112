//! The list of sessions, and operations on whole sessions.

use protocol::ServerMessage;
use serde_json::{Value, json};
use tokio::task::{spawn_blocking, yield_now};

use crate::client::{
    Client, HttpAnswer, bearer, edit, get, get_unless, make_session, metric, new_session, on_thread, post, post_edits,
    send, send_json, set, state,
};
use crate::server::{OwnServer, SHARED, ServerDoor};

/// Returns the list's entry of a session. `None` if the list leaves it out.
fn entry(door: &ServerDoor, query: &str, name: &str) -> Option<Value> {
    let list = get(door, &format!("/sessions{query}")).json();
    let sessions = list["sessions"].as_array().expect("a list");
    sessions.iter().find(|session| session["name"] == name).cloned()
}

fn patch(door: &ServerDoor, name: &str, body: &Value) -> HttpAnswer {
    send_json(door, "PATCH", &format!("/sessions/{name}"), body)
}

fn delete(door: &ServerDoor, name: &str) -> HttpAnswer {
    send(door, "DELETE", &format!("/sessions/{name}"), &[("authorization", &bearer(door))], b"")
}

fn widen(door: &ServerDoor, session: &str, degrees: u32) -> HttpAnswer {
    let edits = json!([{"command": set("/lights/1/coneAngle", degrees)}]);
    post_edits(door, session, &json!({"actor": {"id": "bob", "name": "Bob"}, "edits": edits}))
}

/// Rules: HTTP-32, HTTP-4
#[tokio::test]
async fn the_list_says_what_changed_last_and_who_is_there() {
    let ada = json!({"id": "ada", "name": "Ada"});
    make_session(&SHARED, &json!({"name": "listed", "title": "Shot 10", "scene": "demo:vases", "actor": ada}));
    let of_list = || entry(&SHARED, "", "listed").expect("an entry");
    let first = of_list();
    let shown = state(&SHARED, "listed");
    assert_eq!(first["title"], "Shot 10");
    assert_eq!([&first["epoch"], &first["seq"]], [&shown["epoch"], &shown["seq"]]);
    assert_eq!([&first["clients"], &first["people"], &first["archived"]], [&json!(0), &json!([]), &json!(false)]);
    assert_eq!(first["changed"]["actor"], "Ada", "who made it loaded its scene");
    let (made, changed) = (first["madeMs"].as_u64().expect("made"), &first["changed"]["timeMs"]);
    assert!(changed.as_u64().expect("changed").abs_diff(made) < 3_600_000, "{first}");

    assert_eq!(widen(&SHARED, "listed", 20).status, 200);
    let second = of_list();
    assert_eq!((second["seq"].as_u64(), &second["changed"]["actor"]), (Some(2), &json!("Bob")));
    // Two pages of one person are two clients.
    let (_one, _) = Client::join(&SHARED, "listed", "Ada").await;
    let (_two, _) = Client::join(&SHARED, "listed", "Ada").await;
    let (bob, _) = Client::join(&SHARED, "listed", "Bob").await;
    let here = of_list();
    assert_eq!([&here["clients"], &here["people"]], [&json!(3), &json!(["Ada", "Bob"])]);
    drop(bob);
    while of_list()["clients"] != 2 {
        yield_now().await;
    }
    assert_eq!(of_list()["people"], json!(["Ada"]));
    make_session(&SHARED, &json!({"name": "listed-empty"}));
    assert_eq!(entry(&SHARED, "", "listed-empty").expect("an entry")["changed"], Value::Null);
    // A list of one session, and an empty one.
    assert_eq!(get(&SHARED, "/sessions?name=listed").json(), json!({"sessions": [of_list()]}));
    assert_eq!(get(&SHARED, "/sessions?name=nowhere").json(), json!({"sessions": []}));
    let wrong = get(&SHARED, "/sessions?archive=true");
    assert_eq!(wrong.refusal(), (400, "badMessage".into()));
}

/// A hundred sessions are listed in one answer, and none is opened. A test of the store shows that no log is read.
///
/// Rules: HTTP-32, HTTP-12
#[tokio::test]
async fn a_hundred_sessions_are_listed_and_none_is_opened() {
    let own = OwnServer::start().await;
    on_thread(&own.door, |door| {
        for number in 1..100 {
            new_session(door, &format!("shot-{number:03}"));
        }
        assert_eq!(metric(door, "bendylights_rooms"), Some(0.0));
        let list = get(door, "/sessions").json();
        let names: Vec<_> =
            list["sessions"].as_array().expect("a list").iter().map(|one| one["name"].clone()).collect();
        assert_eq!((names.len(), &names[0], &names[99]), (100, &json!("main"), &json!("shot-099")));
        assert_eq!(metric(door, "bendylights_rooms"), Some(0.0));
        get(door, "/sessions/shot-050");
        assert_eq!(metric(door, "bendylights_rooms"), Some(1.0), "one that is opened is counted");
    })
    .await;
    own.stopped().await;
}

/// Rules: HTTP-33, SOCK-14
#[tokio::test]
async fn a_session_gets_a_title_and_is_archived_while_people_work_in_it() {
    new_session(&SHARED, "titled");
    let (mut ada, welcome) = Client::join(&SHARED, "titled", "Ada").await;
    let answer = patch(&SHARED, "titled", &json!({"title": "Küche, abends"}));
    assert_eq!((answer.status, &answer.json()["title"]), (200, &json!("Küche, abends")));
    assert_eq!(answer.json()["people"], json!(["Ada"]));
    let changed = |message| match message {
        ServerMessage::SessionChanged { title, archived } => Some((title, archived)),
        _ => None,
    };
    assert_eq!(ada.until(changed).await, ("Küche, abends".into(), false));
    let answer = patch(&SHARED, "titled", &json!({"archived": true}));
    assert_eq!((&answer.json()["title"], &answer.json()["archived"]), (&json!("Küche, abends"), &json!(true)));
    assert_eq!(ada.until(changed).await, ("Küche, abends".into(), true));
    assert_eq!(entry(&SHARED, "", "titled"), None, "it is hidden");
    assert_eq!(entry(&SHARED, "?archived=false", "titled"), None);
    assert_eq!(entry(&SHARED, "?archived=true", "titled"), Some(answer.json()));
    assert_eq!(entry(&SHARED, "?name=titled", "titled"), Some(answer.json()), "its link finds it");
    // Its link opens it, and its clients continue.
    assert_eq!(widen(&SHARED, "titled", 21).status, 200);
    let logged = |message| if let ServerMessage::Log { record, .. } = message { Some(record.seq) } else { None };
    assert_eq!(ada.until(logged).await, welcome.seq + 1);
    Client::join(&SHARED, "titled", "Bob").await;
    assert_eq!(patch(&SHARED, "titled", &json!({"archived": false})).json()["archived"], false);
    assert!(entry(&SHARED, "", "titled").is_some(), "it is back");
    for (body, status, code) in [
        (json!({"title": " "}), 400, "badName"),
        (json!({"title": "x".repeat(257)}), 400, "badName"),
        (json!({"name": "other"}), 400, "badMessage"),
    ] {
        assert_eq!(patch(&SHARED, "titled", &body).refusal(), (status, code.into()), "{body}");
    }
    assert_eq!(patch(&SHARED, "nowhere", &json!({"title": "x"})).refusal(), (404, "notFound".into()));
}

/// Rules: HTTP-34
#[test]
fn a_session_is_duplicated_with_its_whole_log() {
    new_session(&SHARED, "original");
    for degrees in [20, 21] {
        widen(&SHARED, "original", degrees);
    }
    let copy = post(&SHARED, "/sessions/original/duplicate", r#"{"name": "a-copy", "title": "Original copy"}"#);
    assert_eq!((copy.status, &copy.json()["title"]), (201, &json!("Original copy")), "{}", copy.text());
    let [original, of_copy] = ["original", "a-copy"].map(|name| state(&SHARED, name));
    assert_eq!([&of_copy["seq"], &of_copy["hash"]], [&original["seq"], &original["hash"]]);
    assert_ne!(of_copy["epoch"], original["epoch"]);
    let log = |name: &str| get(&SHARED, &format!("/sessions/{name}/log")).body;
    assert_eq!(log("a-copy"), log("original"));
    // The copy continues independently, from the same history.
    let undo = json!({"actor": {"id": "bob", "name": "Bob"}, "edits": [{"undo": "mine"}]});
    assert_eq!(edit(&SHARED, "a-copy", &undo)["results"][0]["status"], "committed");
    let angle = |name: &str| state(&SHARED, name)["document"]["lights"][0]["light"]["coneAngle"].clone();
    assert_eq!([angle("a-copy"), angle("original")], [json!(20.0), json!(21.0)]);
    let duplicate = |from: &str, body: &str| post(&SHARED, &format!("/sessions/{from}/duplicate"), body).refusal();
    assert_eq!(duplicate("original", r#"{"name": "a-copy"}"#), (409, "exists".into()));
    assert_eq!(duplicate("original", r#"{"name": "a b"}"#), (400, "badName".into()));
    assert_eq!(duplicate("nowhere", r#"{"name": "b-copy"}"#), (404, "notFound".into()));
    assert_eq!(get(&SHARED, "/sessions/b-copy").status, 404);
}

/// Rules: HTTP-35
#[tokio::test]
async fn only_an_archived_session_that_nobody_is_in_is_deleted() {
    new_session(&SHARED, "deleted");
    let epoch = state(&SHARED, "deleted")["epoch"].clone();
    assert_eq!(delete(&SHARED, "deleted").refusal(), (409, "notArchived".into()));
    patch(&SHARED, "deleted", &json!({"archived": true}));
    let (ada, _) = Client::join(&SHARED, "deleted", "Ada").await;
    let refused = delete(&SHARED, "deleted");
    assert_eq!(refused.refusal(), (409, "inUse".into()));
    assert!(refused.text().contains("Ada is in session `deleted`"), "{}", refused.text());
    assert_eq!(widen(&SHARED, "deleted", 22).status, 200, "nothing was done to it");
    drop(ada);
    while entry(&SHARED, "?archived=true", "deleted").expect("an entry")["clients"] != 0 {
        yield_now().await;
    }
    let gone = delete(&SHARED, "deleted");
    assert_eq!((gone.status, gone.body.len()), (204, 0));
    assert_eq!(entry(&SHARED, "?archived=true", "deleted"), None);
    assert_eq!(get(&SHARED, "/sessions/deleted").refusal(), (404, "notFound".into()));
    assert_eq!(widen(&SHARED, "deleted", 23).refusal(), (404, "notFound".into()));
    assert_eq!(delete(&SHARED, "deleted").refusal(), (404, "notFound".into()));
    let mut late = Client::connect(&SHARED).await;
    late.say_hello(&SHARED, "deleted", "Ada").await;
    assert_eq!(late.fatal_error().await.0.name(), "notFound");
    // A new session of its name has nothing of it.
    new_session(&SHARED, "deleted");
    let again = state(&SHARED, "deleted");
    assert_eq!(again["seq"], 1);
    assert_ne!(again["epoch"], epoch);
}

/// A request for a session during its deletion finds all or nothing of it. A room that was open is not found again.
///
/// Rules: HTTP-35
#[tokio::test(flavor = "multi_thread")]
async fn a_session_is_there_or_not_while_it_is_deleted() {
    for round in 0..8 {
        let name = format!("raced-{round}");
        new_session(&SHARED, &name);
        patch(&SHARED, &name, &json!({"archived": true}));
        widen(&SHARED, &name, 20);
        let path = format!("/sessions/{name}");
        let asked_path = path.clone();
        let asked = spawn_blocking(move || (0..20).map(|_| get(&SHARED, &asked_path).status).collect::<Vec<_>>());
        let deleted = on_thread(&SHARED, move |door| delete(door, &name).status).await;
        assert_eq!((deleted, get(&SHARED, &path).status), (204, 404));
        let statuses = asked.await.unwrap();
        assert!(statuses.iter().all(|status| [200, 404, 503].contains(status)), "{statuses:?}");
        let first_gone = statuses.iter().position(|status| *status == 404).unwrap_or(statuses.len());
        assert!(statuses[first_gone..].iter().all(|status| *status == 404), "it never comes back: {statuses:?}");
    }
}

/// Rules: HTTP-36, HTTP-24
#[test]
fn the_scenes_that_come_with_the_server_make_sessions() {
    let scenes = get(&SHARED, "/scenes");
    let demos = scenes.json()["demos"].as_array().expect("demos").clone();
    assert!(demos.len() > 1, "{demos:?}");
    for (number, demo) in demos.iter().enumerate() {
        let session = json!({"name": format!("of-a-demo-{number}"), "scene": demo["scene"]});
        assert_eq!(make_session(&SHARED, &session)["document"]["scene"]["name"], demo["scene"]);
        assert!(demo["shows"].as_str().expect("words").len() > 10, "{demo}");
    }
    let tag = scenes.headers["etag"].to_str().expect("text");
    assert_eq!(get_unless(&SHARED, "/scenes", tag).status, 304);
}

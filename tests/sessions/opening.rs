//! The work of opening a session.

use serde_json::{Value, json};

use crate::sessions::support::Server;

fn edit(server: &Server, edit: &Value) {
    let answer = server.post("/sessions/main/edits", &json!({"edits": [edit]})).text();
    let answer: Value = serde_json::from_str(&answer).expect("JSON");
    assert_eq!(answer["results"][0]["status"], "committed", "{answer}");
}

fn decoded(server: &Server) -> f64 {
    server.metric("scenes_decoded_total", "")
}

/// A decoded scene can take gigabytes: of all scenes that a log has loaded, only the drawn one is decoded.
///
/// Rules: LOG-3, HTTP-8, HTTP-9, UNDO-1
#[test]
fn a_session_opens_without_the_scenes_of_its_past() {
    let server = Server::start_process();
    for demo in ["demo:arbor", "demo:vases", "demo:arbor"] {
        edit(&server, &json!({"command": {"type": "loadScene", "scene": demo}}));
    }
    let light = server.connect("ada").light();
    edit(&server, &json!({"command": {"type": "setLight", "light": light, "parameter": {"name": "last"}}}));
    assert_eq!(decoded(&server), 2.0, "the count counts: both demos");

    let server = server.restart();
    assert_eq!(decoded(&server), 0.0);
    assert_eq!(server.state().0, 5);
    assert_eq!(decoded(&server), 1.0, "the present one");
    // An earlier state is replayed from the first record.
    let picture = server.get("/sessions/main/render?at=4&size=16x16");
    assert_eq!((picture.status, decoded(&server)), (200, 1.0));
    edit(&server, &json!({"undo": "session"}));
    assert_eq!(decoded(&server), 1.0, "of a light");
    edit(&server, &json!({"undo": "session"}));
    assert_eq!(decoded(&server), 2.0, "the scene before is the present one again");
}

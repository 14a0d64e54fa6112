//! Hard pins in edits and gestures other than drags of features.

use glam::DVec3;
use protocol::{
    Change, ClientMessage, Command, DragRadii, ErrorCode, GestureState, GestureStatus, Outcome, Pin, PinKind,
    PinTarget, ServerMessage,
};
use serde_json::{Value, json};

use crate::client::{Client, get, new_session, post_edits, state};
use crate::server::SHARED;

/// Point of the blue vase that the demo's light reaches.
fn lit_point(session: &str) -> [f64; 3] {
    let camera = state(&SHARED, session)["document"]["cameras"][0]["camera"].clone();
    let query = json!([{"light": 0, "kind": "hotspot", "camera": camera, "size": [640, 360],
        "from": [165.5, 150.5], "to": [165.5, 150.5]}]);
    let answer = crate::client::post(&SHARED, &format!("/sessions/{session}/drags"), &query).json();
    let results = answer.as_array().or_else(|| answer["results"].as_array()).expect("answers").clone();
    serde_json::from_value(results[0]["fromWorld"].clone()).expect("a surface")
}

/// Adds a hard pin to the demo's light, and returns the point.
fn pin(session: &str, kind: PinKind) -> [f64; 3] {
    let at = lit_point(session);
    let pin = Pin { kind, light: 1, at: PinTarget::Point(at), caster: None, hard: true };
    let added = post_edits(&SHARED, session, &json!({"edits": [{"command": Command::AddPin { pin }}]})).json();
    assert_eq!(added["results"][0]["status"], "committed", "{added}");
    at
}

/// Returns the position of control point 3 of the demo's light.
fn third_point(session: &str) -> DVec3 {
    let light = state(&SHARED, session)["document"]["lights"][0]["light"].clone();
    DVec3::from_array(serde_json::from_value(light["points"][3].clone()).expect("a position"))
}

fn drag_point(position: DVec3, ignore_pins: bool) -> Command {
    let position = position.to_array();
    Command::DragPoint { light: 1, point: 3, position, radii: DragRadii::Follow, ignore_pins }
}

/// Returns the state of a gesture after an update.
async fn updated(client: &mut Client, number: u64) -> GestureState {
    let of_update = |message| match message {
        ServerMessage::GestureState(state) if state.update == number => Some(state),
        _ => None,
    };
    client.until(of_update).await
}

/// Position of control point 3 that a gesture shows; `None` if it does not move.
fn position(state: &GestureState) -> Option<DVec3> {
    state.changes.iter().find_map(|change| {
        let text = serde_json::to_value(change).expect("JSON");
        let is_position = matches!(change, Change::Point { point: 3, .. }) && text.to_string().contains("position");
        is_position
            .then(|| serde_json::from_value(text["new"]["position"].clone()).ok())
            .flatten()
            .map(DVec3::from_array)
    })
}

/// A gesture that drags a control point slides along a hard pin; with `ignorePins` the point goes where it is asked.
/// Many updates at once are solved as drags of features are: the last one counts.
///
/// Rules: CMD-18, GEST-7, GEST-8
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_dragged_control_point_slides_along_a_pin() {
    new_session(&SHARED, "pinned-point");
    let from = tokio::task::spawn_blocking(|| {
        pin("pinned-point", PinKind::Direction);
        third_point("pinned-point")
    });
    let from = from.await.unwrap();
    let to = from + DVec3::new(0.2, 0.3, -0.1);
    let (mut ada, welcome) = Client::join(&SHARED, "pinned-point", "Ada").await;
    let (gesture, base_seq) = (|| String::from("slide"), welcome.seq);
    ada.say(&ClientMessage::GestureBegin { gesture: gesture(), light: 1, base_seq }).await;
    for update in 1..=20 {
        let command = drag_point(from.lerp(to, update as f64 / 20.0), false);
        ada.say(&ClientMessage::GestureUpdate { gesture: gesture(), update, command }).await;
    }
    let slid = updated(&mut ada, 20).await;
    assert_eq!(slid.status, GestureStatus::Held { refused: None });
    let slid = position(&slid).expect("it moves");
    assert!(slid.distance(to) > 0.01 && slid.distance(from) > 0.005, "{from} {slid} {to}");
    // The planted fault: without the pin the point reaches the cursor.
    let command = drag_point(to, true);
    ada.say(&ClientMessage::GestureUpdate { gesture: gesture(), update: 21, command }).await;
    let free = position(&updated(&mut ada, 21).await).expect("it moves");
    assert!(free.distance(to) < 1e-9, "{free} {to}");
    // A commit records the command and the light that slid.
    let command = drag_point(to, false);
    ada.say(&ClientMessage::GestureUpdate { gesture: gesture(), update: 22, command }).await;
    assert_eq!(position(&updated(&mut ada, 22).await), Some(slid));
    ada.say(&ClientMessage::GestureCommit { gesture: gesture(), op_id: "done".into() }).await;
    assert!(matches!(ada.outcome("done").await, Outcome::Committed(_)));
    let now = tokio::task::spawn_blocking(|| third_point("pinned-point")).await.unwrap();
    assert_eq!(now, slid);
    let log = tokio::task::spawn_blocking(move || {
        get(&SHARED, &format!("/sessions/pinned-point/log?from={}&limit=1", base_seq + 1)).text().to_owned()
    });
    let record: Value = serde_json::from_str(&log.await.unwrap()).expect("a record");
    assert_eq!(record["action"]["command"]["position"], json!(to.to_array()), "{record}");
}

/// A field that would break a hard pin is refused with the pin's name, alone, by its address and in a group. With
/// `ignorePins` it is set. A field of brightness is set in any case.
///
/// Rules: CMD-18, CMD-17, CMD-8
#[test]
fn fields_that_break_a_pin_are_refused_by_its_name() {
    new_session(&SHARED, "pinned-field");
    pin("pinned-field", PinKind::Lit);
    let before = state(&SHARED, "pinned-field");
    let send = |body: Value| post_edits(&SHARED, "pinned-field", &body).json()["results"].clone();
    let shrink = |ignore_pins: bool| {
        let mut command = json!({"type": "setLight", "light": 1, "parameter": {"scale": 0.2}});
        if ignore_pins {
            command["ignorePins"] = json!(true);
        }
        command
    };
    let by_address = json!({"type": "set", "target": "/lights/key/scale", "value": 0.2});
    let brighter = json!({"type": "set", "target": "/lights/key/exposure", "value": 1});
    let one = |command: &Value| send(json!({"edits": [{"command": command}]}))[0].clone();
    let grouped = json!({"atomic": true, "opId": "all", "edits": [{"command": brighter}, {"command": shrink(false)}]});
    for refused in [one(&shrink(false)), one(&by_address), send(grouped)[0].clone()] {
        assert_eq!((&refused["status"], &refused["code"]), (&json!("rejected"), &json!(ErrorCode::Drag)), "{refused}");
        let said = refused["message"].as_str().expect("a sentence");
        assert!(said.contains("its pin “Lit") && said.contains("would no longer hold"), "{said}");
    }
    assert_eq!(state(&SHARED, "pinned-field")["hash"], before["hash"], "nothing has changed");
    assert_eq!(one(&brighter)["status"], "committed");
    // The planted fault: passed over, the pin breaks.
    assert_eq!(one(&shrink(true))["status"], "committed");
    let mut ignoring = by_address.clone();
    ignoring["ignorePins"] = json!(true);
    ignoring["value"] = json!(0.1);
    assert_eq!(one(&ignoring)["status"], "committed");
}

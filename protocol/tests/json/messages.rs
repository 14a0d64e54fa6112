//! Tests of the socket's messages against SPEC.md.

use std::collections::BTreeSet;

use protocol::{ClientMessage, SchemaSide, ServerMessage, json_schema, parse_body};
use serde_json::{Value, json};

fn camera() -> Value {
    let projection = json!({"perspective": {"yfov": 0.75, "znear": 0.125}});
    json!({"name": "", "translation": [0.0, 1.5, 5.0], "rotation": [0.0, 0.0, 0.0, 1.0], "projection": projection})
}

/// Returns one message of each type.
fn from_the_client() -> Vec<Value> {
    let actor = json!({"id": "a", "name": "Ada"});
    let command = json!({"type": "setLight", "light": 1, "parameter": {"coneAngle": 30.5}});
    vec![
        json!({"type": "hello", "protocol": 1, "token": "t", "session": "main", "actor": actor}),
        json!({"type": "hello", "protocol": 1, "token": "t", "session": "main", "actor": actor, "epoch": "e", "lastSeq": 7}),
        json!({"type": "openView", "source": {"own": camera()}, "width": 686, "height": 382, "cameraRevision": 1}),
        json!({"type": "openView", "source": {"follow": 2}, "width": 686, "height": 382, "cameraRevision": 0}),
        json!({"type": "setCamera", "camera": camera(), "cameraRevision": 2}),
        json!({"type": "openView", "source": {"own": camera()}, "width": 686, "height": 382, "cameraRevision": 1,
            "settings": {"exposure": 0.5, "solo": []}}),
        json!({"type": "setView", "settings": {"exposure": -1.5, "solo": [1, 4]}, "cameraRevision": 3}),
        json!({"type": "viewport", "width": 800, "height": 600}),
        json!({"type": "openView", "source": {"follow": 2}, "width": 686, "height": 382, "cameraRevision": 0, "stats": true}),
        json!({"type": "setView", "settings": {"exposure": 0.0, "solo": []}, "stats": false, "cameraRevision": 3}),
        json!({"type": "ack", "frame": 9}),
        json!({"type": "requestKeyFrame", "frame": 9}),
        json!({"type": "edit", "opId": "x", "baseSeq": 7, "command": command}),
        json!({"type": "gestureBegin", "gesture": "g", "light": 1, "baseSeq": 7}),
        json!({"type": "gestureUpdate", "gesture": "g", "update": 1, "command": command}),
        json!({"type": "gestureCommit", "gesture": "g", "opId": "y"}),
        json!({"type": "gestureCancel", "gesture": "g"}),
        json!({"type": "undo", "opId": "z", "scope": "mine"}),
        json!({"type": "redo", "opId": "z", "scope": "session"}),
        json!({"type": "presence", "selection": 1}),
        json!({"type": "presence", "selection": null}),
        json!({"type": "probe", "probe": "p", "pixel": [430.5, 265.5]}),
        json!({"type": "probe", "probe": "p", "pixel": [0.5, 0.5], "camera": {"id": 3}, "size": [640, 360]}),
        json!({"type": "probe", "probe": "p", "pixel": [0.5, 0.5], "camera": {"own": camera()}, "size": [640, 360]}),
        json!({"type": "ping", "sent": 1234.5}),
    ]
}

/// Returns one command of each type.
fn commands() -> Vec<Value> {
    let light = json!({"type": "spot", "name": "lamp", "transform": {"translation": [0.0, 0.0, 0.0],
        "rotation": [0.0, 0.0, 0.0, 1.0], "scale": 1.0}, "color": [1.0, 1.0, 1.0], "intensity": 1.0,
        "coneAngle": 25.0, "coneSoftness": 0.25, "decay": "inverseSquare"});
    let mut commands = vec![
        json!({"type": "loadScene", "scene": "demo:vases"}),
        json!({"type": "addLight", "light": light}),
        json!({"type": "removeLight", "light": 1}),
        json!({"type": "placeLight", "light": 1, "translation": [1.0, 2.0, 3.0], "scale": 2.0}),
        json!({"type": "placeLight", "light": 1, "rotation": [0.0, 0.0, 0.0, 1.0]}),
        json!({"type": "insertPoint", "light": 1, "point": 2}),
        json!({"type": "insertPoint", "light": 1, "point": 2, "position": [0.0, 0.0, 1.0], "radius": 0.5,
            "color": [1.0, 0.0, 0.0], "intensity": 2.0}),
        json!({"type": "removePoint", "light": 1, "point": 2}),
        json!({"type": "addCamera", "camera": camera()}),
        json!({"type": "removeCamera", "camera": 3}),
        json!({"type": "placeCamera", "camera": 3, "translation": [0.0, 0.0, 0.5]}),
        json!({"type": "setCamera", "camera": 3, "parameter": {"name": "side"}}),
        json!({"type": "setCamera", "camera": 3, "parameter": {"projection":
            {"orthographic": {"ymag": 1.0, "znear": 0.0, "zfar": 9.0}}}}),
        json!({"type": "set", "target": "/lights/1/coneAngle", "value": 30.5}),
        json!({"type": "dragPoint", "light": 1, "point": 2, "position": [0.0, 0.0, 0.5], "radii": "follow"}),
        json!({"type": "dragFeature", "light": 1, "kind": "shadow", "points": [1, 2], "radii": "keep",
            "camera": camera(), "size": [640, 360], "from": [1.5, 2.5], "to": [3.5, 4.5], "sourceOutside": true}),
        json!({"type": "addPin", "pin": {"kind": "shadow", "light": 1, "at": [0.0, 0.5, 0.0], "caster": "vase",
            "hard": true}}),
        json!({"type": "removePin", "pin": 1}),
        json!({"type": "setPin", "pin": 1, "hard": false}),
        json!({"type": "bendLight", "light": 1, "segments": 3, "range": 6.5, "coneAngle": 45.0,
            "toward": [0.0, 0.0, 0.0]}),
        json!({"type": "straightenLight", "light": 1}),
    ];
    let parameters = [
        json!({"name": "key"}),
        json!({"translation": [0.0, 0.0, 0.5]}),
        json!({"rotation": [0.0, 0.0, 0.0, 1.0]}),
        json!({"scale": 2.0}),
        json!({"coneAngle": 30.5}),
        json!({"coneSoftness": 0.5}),
        json!({"decay": "linear"}),
        json!({"up": [0.0, 1.0, 0.0]}),
        json!({"frame": "rotationMinimizing"}),
        json!({"direction": "path"}),
        json!({"endMode": "extend"}),
        json!({"color": [1.0, 0.5, 0.25]}),
        json!({"intensity": 2.0}),
        json!({"range": 6.5}),
        json!({"range": null}),
    ];
    commands.extend(parameters.map(|parameter| json!({"type": "setLight", "light": 1, "parameter": parameter})));
    let of_points = [
        json!({"position": [0.0, 0.0, 0.5]}),
        json!({"radius": 0.5}),
        json!({"color": [1.0, 0.5, 0.25]}),
        json!({"intensity": 2.0}),
    ];
    commands
        .extend(of_points.map(|parameter| json!({"type": "setPoint", "light": 1, "point": 2, "parameter": parameter})));
    commands
}

fn edit(command: &Value) -> Value {
    json!({"type": "edit", "opId": "x", "baseSeq": 0, "command": command})
}

fn from_the_server() -> Vec<Value> {
    let hash = "0".repeat(64);
    let actor = json!({"id": "a", "name": "Ada"});
    let bounds = json!({"min": [-1.0, 0.0, -1.0], "max": [1.0, 2.0, 1.0]});
    let notes = ["points and lines are not drawn: fence"];
    let presence = json!({"client": 1, "actor": actor, "selection": null, "following": 2, "camera": camera(), "settings": {"exposure": 0.5, "solo": [2]}});
    let gesture = json!({"gesture": "g", "client": 1, "light": 1, "update": 3, "liveRevision": 4, "changes": []});
    let action = json!({"type": "edit", "command": {"type": "removeLight", "light": 1}});
    let record =
        json!({"format": 1, "seq": 1, "timeMs": 0, "actor": actor, "opId": "x", "action": action, "changes": []});
    let settings = json!({"ackWindow": 3, "leaseMs": 30_000, "maxViewSide": 4096});
    let welcome = |state: Value| {
        json!({"type": "welcome", "protocol": 1, "session": "main", "client": 1, "epoch": "e", "seq": 1, "hash": hash,
            "state": state, "bounds": bounds, "notes": notes, "camera": camera(), "clients": [presence],
            "gestures": [gesture], "settings": settings})
    };
    let mut ended = gesture.clone();
    for (field, value) in [("type", "gestureState"), ("ended", "rejected"), ("code", "stale"), ("message", "m")] {
        ended[field] = value.into();
    }
    let run = json!({"pass": "shadowMap", "light": 1, "cause": "light", "runs": 1});
    let display = json!({"pass": "display", "light": null, "cause": "notKept", "runs": 1});
    vec![
        json!({"type": "stats", "frame": 9, "waitUs": 1, "renderUs": 2, "encodeUs": 3, "bytes": 4, "tiles": 5,
            "size": [64, 36], "shadowMapDivisor": 2, "quality": "moving", "passes": [run, display]}),
        welcome(json!({"snapshot": {"scene": null, "lights": [], "cameras": []}})),
        welcome(json!({"tail": [record]})),
        json!({"type": "log", "record": record, "hash": hash}),
        json!({"type": "log", "record": record, "hash": hash, "bounds": bounds, "notes": notes}),
        json!({"type": "editResult", "opId": "x", "status": "committed", "seq": 1}),
        json!({"type": "editResult", "opId": "x", "status": "rebased", "seq": 1, "skipped": ["s"]}),
        json!({"type": "editResult", "opId": "x", "status": "rejected", "code": "stale", "message": "m"}),
        ended,
        json!({"type": "presence", "clients": [presence]}),
        json!({"type": "viewConfig", "width": 686, "height": 382, "source": {"follow": 2}}),
        json!({"type": "pong", "sent": 1234.5, "serverTimeUs": 9}),
        json!({"type": "sessionChanged", "title": "Shot 10", "archived": false}),
        json!({"type": "draining", "retryAfterMs": 1000}),
        json!({"type": "error", "code": "badMessage", "message": "m", "fatal": false}),
    ]
}

/// Rules: SOCK-6, SOCK-7, GEST-1
#[test]
fn messages_of_clients_are_read_and_written_alike() {
    for message in from_the_client().into_iter().chain(commands().iter().map(edit)) {
        let read: ClientMessage = parse_body(&message.to_string()).expect("as SPEC.md says");
        assert_eq!(serde_json::to_value(read).expect("plain data"), message);
    }
}

/// Rules: SOCK-7
#[test]
fn the_commands_here_are_of_every_type() {
    let schema = json_schema(SchemaSide::Read);
    let mapping = schema["$defs"]["Command"]["discriminator"]["mapping"].as_object().expect("a type to a schema");
    let here: BTreeSet<_> =
        commands().iter().map(|command| command["type"].as_str().expect("a type").to_owned()).collect();
    assert_eq!(here, mapping.keys().cloned().collect());
}

/// Rules: SOCK-2, SOCK-3, SOCK-8
#[test]
fn messages_of_the_server_are_read_and_written_alike() {
    for message in from_the_server() {
        let read: ServerMessage = parse_body(&message.to_string()).expect("as SPEC.md says");
        assert_eq!(serde_json::to_value(read).expect("plain data"), message);
    }
}

/// Returns copies of `value`, each with an unknown field in another object.
fn with_gobo(value: &Value) -> Vec<Value> {
    let mut planted = Vec::new();
    if let Value::Object(fields) = value {
        let mut here = value.clone();
        here["gobo"] = json!(1);
        planted.push(here);
        for (name, field) in fields {
            planted.extend(with_gobo(field).into_iter().map(|field| {
                let mut outer = value.clone();
                outer[name] = field;
                outer
            }));
        }
    }
    planted
}

/// Rules: SOCK-6
#[test]
fn fields_that_nobody_knows_are_refused() {
    for message in from_the_client().into_iter().chain(commands().iter().map(edit)) {
        for planted in with_gobo(&message) {
            let text = planted.to_string();
            let said = parse_body::<ClientMessage>(&text).expect_err(&text).to_string();
            // An object that represents a choice has exactly one field, so the error need not name the second
            // one.
            assert!(said.contains("`gobo`") || said.contains("map with a single key"), "{text}: {said}");
        }
    }
}

/// Rules: SOCK-6
#[test]
fn the_reason_says_what_is_wrong() {
    let said = |message: Value| parse_body::<ClientMessage>(&message.to_string()).expect_err("a fault").to_string();
    let set_point =
        |parameter: Value| edit(&json!({"type": "setPoint", "light": 1, "point": 2, "parameter": parameter}));
    for (message, words) in [
        (json!({"type": "paint"}), "`paint`"),
        (json!({"frame": 1}), "`type`"),
        (json!({"type": "ack"}), "`frame`"),
        (json!({"type": "ack", "frame": -1}), "the number -1"),
        (json!({"type": "undo", "opId": "x", "scope": "ours"}), "`ours`"),
        (edit(&json!({"type": "paint"})), "`paint`"),
        (set_point(json!({"colour": [1, 1, 1]})), "`colour`"),
        (set_point(json!({"position": [1, 1]})), "an array of 3"),
        (set_point(json!({"radius": "1"})), "a number should be"),
        (edit(&json!({"type": "addLight", "light": {"type": "spot", "coneAngle": "x"}})), "light.coneAngle"),
        (edit(&json!({"type": "addLight", "light": {"type": "laser"}})), "light.type"),
    ] {
        let sentence = said(message.clone());
        assert!(sentence.contains(words), "{message}: {sentence}");
    }
    for text in ["", "{", "ping", "{\"type\": \"ping\", \"sent\": NaN}", "{\"type\": \"ping\", \"sent\": 1e999}"] {
        parse_body::<ClientMessage>(text).expect_err(text);
    }
}

#[test]
fn json_is_cut_around_its_document() {
    let document = || protocol::Document { scene: None, ..protocol::Document::default() };
    let empty = serde_json::to_string(&document()).unwrap();
    let state = |document| protocol::SessionState {
        name: format!("\"document\":{empty}"),
        epoch: format!("\":{empty}"),
        seq: 1,
        hash: String::new(),
        document,
        notes: vec![format!("x\":{empty}")],
    };
    let (before, after) = protocol::json_around_document(&state(document()));
    assert!(before.ends_with("\"document\":") && after.starts_with(",\"notes\":"), "{before} | {after}");
    let scene = protocol::SceneRef { asset: "sha256:0".into(), name: "a \"scene\"".into() };
    let full = protocol::Document { scene: Some(scene), ..document() };
    let whole = before + &serde_json::to_string(&full).unwrap() + &after;
    assert_eq!(whole, serde_json::to_string(&state(full)).unwrap());
}

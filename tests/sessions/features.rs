//! Shadows and highlights dragged in sessions: live, pinned, recorded, replayed, and queried without an edit.

use protocol::{
    Action, ClientMessage, Command, DragKind, DragLimit, DragOutcome, DragRadii, DragStatus, ErrorCode,
    GestureStatus, Pin, PinKind, Record, Scope, parse_body,
};
use serde_json::{Value, json};

use crate::program::program;
use crate::sessions::support::{Mirror, Server, committed, rejected, state_of};

const SIZE: [u32; 2] = [640, 360];
/// A pixel in the shadow of the blue vase's neck.
const SHADOW: [f64; 2] = [430.5, 265.5];

/// The drag of docs/command-line.md: moves that shadow down the table by `down` pixels.
fn drag(mirror: &Mirror, points: Option<Vec<usize>>, down: f64) -> Command {
    let camera = mirror.document.cameras().values().next().expect("the demo has a camera");
    Command::DragFeature {
        light: mirror.light(),
        kind: DragKind::Shadow,
        points,
        radii: DragRadii::Keep,
        camera: camera.into(),
        size: SIZE,
        from: SHADOW,
        to: [SHADOW[0], SHADOW[1] + down],
        source_outside: false,
    }
}

fn send_update(mirror: &mut Mirror, update: u64, command: Command) {
    mirror.send(&ClientMessage::GestureUpdate { gesture: "drag".into(), update, command });
}

fn begin(mirror: &mut Mirror) {
    let (light, base_seq) = (mirror.light(), mirror.seq);
    mirror.send(&ClientMessage::GestureBegin { gesture: "drag".into(), light, base_seq });
}

/// The record of that number, over HTTP.
fn record(server: &Server, seq: u64) -> Record {
    let log = server.process.get(&format!("/sessions/main/log?from={seq}")).expect("answered").text();
    let line = log.lines().find(|line| line.contains(&format!("\"seq\":{seq},"))).expect("the record");
    serde_json::from_str(line).expect("a record")
}

fn outcome(record: &Record) -> DragOutcome {
    let (Action::Edit { outcome, .. } | Action::Gesture { outcome, .. }) = &record.action else {
        panic!("{record:?}")
    };
    outcome.as_deref().expect("a drag has an outcome").clone()
}

fn light_json(mirror: &Mirror) -> String {
    let document = protocol::Document::from(&mirror.document);
    serde_json::to_string(&document.lights[0].light).expect("JSON")
}

/// All clients see the drag and its outcome. The result depends on the final cursor and not on its path. The drag is
/// one record and one undo step.
///
/// Rules: CMD-15, GEST-1, GEST-4, REC-2, REC-7, DRAG-2
#[test]
fn a_shadow_is_dragged_live_and_is_one_record() {
    let server = Server::start();
    let (mut ada, mut ben) = (server.connect("ada"), server.connect("ben"));
    let (seq, began) = (ada.seq, light_json(&ada));
    begin(&mut ada);
    let points = || Some(vec![2, 3, 4]);
    let mut dragged = |update: u64, down: f64| {
        let command = drag(&ada, points(), down);
        send_update(&mut ada, update, command);
        let state = state_of(&mut ada, |state| state.update == update);
        assert_eq!(state.status, GestureStatus::Held { refused: None });
        (state.changes, state.outcome.expect("an outcome"))
    };
    let (there, landed) = dragged(1, 45.0);
    assert_eq!(landed.status, DragStatus::Landed);
    assert!(landed.residual_px.expect("in the picture") <= 0.5 && landed.pivot_world.is_some());
    let (elsewhere, _) = dragged(2, 20.0);
    assert_ne!(there, elsewhere);
    assert_eq!(dragged(3, 45.0).0, there, "begin and cursor alone count");
    let seen = state_of(&mut ben, |state| state.update == 3);
    assert_eq!((seen.changes, seen.outcome.map(|outcome| outcome.status)), (there, Some(DragStatus::Landed)));

    // Off the table the drag has no surface to land on: the light stays, and follows when the cursor comes back.
    let mut off = drag(&ada, points(), 45.0);
    if let Command::DragFeature { to, .. } = &mut off {
        *to = [-9000.5, -9000.5];
    }
    send_update(&mut ada, 4, off);
    let refused = state_of(&mut ada, |state| state.status.problem().is_some());
    assert_eq!((refused.update, refused.status.problem().map(|p| p.code)), (4, Some(ErrorCode::Drag)));

    ada.send(&ClientMessage::GestureCommit { gesture: "drag".into(), op_id: "commit".into() });
    assert_eq!(committed(&ada.result("commit")), seq + 1);
    let record = record(&server, seq + 1);
    assert_eq!(outcome(&record), *landed);
    assert!(record.changes.len() == 3, "three control points: {record:?}");
    ben.catch_up(seq + 1);
    let moved = light_json(&ben);
    assert_ne!(moved, began);
    let op_id = ada.op_id();
    ada.send(&ClientMessage::Undo { op_id: op_id.clone(), scope: Scope::Mine });
    committed(&ada.result(&op_id));
    assert_eq!(light_json(&ada), began, "one step takes it back");

    // The same drag as a single edit gives the same light.
    let command = drag(&ada, points(), 45.0);
    committed(&ada.edited(command));
    assert_eq!(light_json(&ada), moved);
}

/// Updates that arrive faster than they are solved are skipped, except the last one.
///
/// Rules: GEST-7, GEST-1
#[test]
fn superseded_updates_are_skipped() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    begin(&mut ada);
    let count = 300;
    for update in 1..=count {
        let command = drag(&ada, None, 45.0 * update as f64 / count as f64);
        send_update(&mut ada, update, command);
    }
    let mut answers = 0;
    let last = state_of(&mut ada, |state| {
        answers += u64::from(state.update > 0);
        state.update == count
    });
    assert_eq!(last.outcome.map(|outcome| outcome.status), Some(DragStatus::Landed));
    assert!(answers < count, "all of {count} were solved");
}

/// Rules: CMD-15, DRAG-5, DOC-6, GEST-2
#[test]
fn pins_are_everybodys_and_hold() {
    let server = Server::start();
    let (mut ada, mut ben) = (server.connect("ada"), server.connect("ben"));
    let light = ada.light();
    // The surface in the shadow.
    let asked = json!([{"light": 0, "kind": "shadow", "size": SIZE, "from": SHADOW, "to": SHADOW}]);
    let asked = ask(&server, &asked);
    let at: [f64; 3] = serde_json::from_value(asked[0]["fromWorld"].clone()).expect("a place");
    let pin = Pin { kind: PinKind::Direction, light, at, caster: None, hard: true };
    committed(&ben.edited(Command::AddPin { pin: pin.clone() }));
    ada.catch_up(ben.seq);
    let id = ada.document.pins().keys().next().expect("a pin").0;
    assert_eq!(protocol::Document::from(&ada.document).pins[0].pin, pin);

    // One control point cannot direct the light path to the cursor and keep its direction here: the answer names the
    // pin.
    let command = drag(&ada, Some(vec![3]), 20.0);
    let began = light_json(&ada);
    committed(&ada.edited(command.clone()));
    let held = outcome(&record(&server, ada.seq));
    assert_eq!((held.status, held.limit, held.pin), (DragStatus::Limited, Some(DragLimit::Pin), Some(id)));
    let op_id = ada.op_id();
    ada.send(&ClientMessage::Undo { op_id: op_id.clone(), scope: Scope::Mine });
    committed(&ada.result(&op_id));
    assert_eq!(light_json(&ada), began);

    // No client can pin a light that another one drags.
    begin(&mut ada);
    let little = drag(&ada, None, 5.0);
    send_update(&mut ada, 1, little);
    state_of(&mut ada, |state| state.update == 1);
    assert_eq!(rejected(&ben.edited(Command::AddPin { pin })).code, ErrorCode::Locked);
    ada.send(&ClientMessage::GestureCancel { gesture: "drag".into() });
    state_of(&mut ben, |state| matches!(state.status, GestureStatus::Cancelled { .. }));

    // Without the pin the same drag lands.
    committed(&ben.edited(Command::RemovePin { pin: id }));
    ada.catch_up(ben.seq);
    committed(&ada.edited(command));
    assert_eq!(outcome(&record(&server, ada.seq)).status, DragStatus::Landed);
}

fn ask(server: &Server, drags: &Value) -> Vec<Value> {
    let response =
        server.process.post("/sessions/main/drags", drags.to_string().as_bytes()).expect("answered");
    assert_eq!(response.status, 200, "{}", response.text());
    parse_body(&response.text()).expect("an array")
}

/// Rules: HTTP-23, DRAG-2, DRAG-4
#[test]
fn programs_ask_where_drags_would_lead() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    let (seq, hash) = server.state();
    let one = json!({"light": "key", "kind": "shadow", "points": [2, 3, 4], "size": SIZE, "from": SHADOW, "to": [430.5, 310.5]});
    let other = json!({"light": 0, "kind": "hotspot", "size": SIZE, "from": [300.5, 300.5], "to": [320.5, 310.5], "camera": 0});
    let there = ask(&server, &json!([one, other]));
    let back = ask(&server, &json!([other, one]));
    let without_seconds = |answer: &Value| {
        let mut answer = answer.clone();
        answer.as_object_mut().expect("an object").remove("seconds").expect("it took a while");
        answer
    };
    assert_eq!(without_seconds(&there[0]), without_seconds(&back[1]), "the order is no matter");
    assert_eq!(without_seconds(&there[1]), without_seconds(&back[0]));
    assert_eq!(there[0]["status"], "landed");
    assert_eq!(server.state(), (seq, hash), "nothing is edited");

    // Result of the command line for the same scene and drag.
    let file = server.data.path().join("drags.json");
    std::fs::write(&file, json!([one]).to_string()).expect("written");
    let output = std::process::Command::new(program()).arg("drag").arg("demo:vases").arg(&file).output();
    let printed: Vec<Value> = serde_json::from_slice(&output.expect("it runs").stdout).expect("JSON");
    assert_eq!(without_seconds(&printed[0]), without_seconds(&there[0]));

    // The document's pins apply unless the request has its own.
    let at = there[0]["fromWorld"].clone();
    let pin = json!({"kind": "lit", "light": ada.light(), "at": at, "hard": true});
    committed(&ada.edited(serde_json::from_value(json!({"type": "addPin", "pin": pin})).expect("a command")));
    let id = ada.document.pins().keys().next().expect("a pin").0;
    let held = ask(&server, &json!([one]));
    assert_eq!((&held[0]["status"], &held[0]["reason"]), (&json!("refused"), &json!("pinDoesNotHold")));
    assert_eq!(held[0]["pin"], id);
    let mut free = one.clone();
    free["pins"] = json!([]);
    assert_eq!(ask(&server, &json!([free]))[0]["status"], "landed");

    for (wrong, code) in [
        (
            json!([{"light": "nobody", "kind": "shadow", "size": SIZE, "from": SHADOW, "to": SHADOW}]),
            "notFound",
        ),
        (
            json!([{"light": 0, "kind": "shadow", "camera": "none", "size": SIZE, "from": SHADOW, "to": SHADOW}]),
            "notFound",
        ),
        (json!([{"light": 0, "kind": "shadow", "size": [0, 9], "from": SHADOW, "to": SHADOW}]), "drag"),
        (
            json!([{"light": 0, "kind": "shadow", "size": [99999, 9], "from": SHADOW, "to": SHADOW}]),
            "tooLarge",
        ),
        (json!([{"light": 0, "kind": "glow", "size": SIZE, "from": SHADOW, "to": SHADOW}]), "badMessage"),
        (json!({}), "badMessage"),
    ] {
        let refused =
            server.process.post("/sessions/main/drags", wrong.to_string().as_bytes()).expect("answered");
        let error: protocol::ErrorBody = parse_body(&refused.text()).expect("an error");
        assert_eq!(error.error.code.name(), code, "{wrong}: {}", refused.text());
    }
}

/// Replay uses the recorded values; with `--resolve` it solves again and reports the difference.
///
/// Rules: REC-2, REC-7
#[test]
fn a_log_is_solved_again() {
    let server = Server::start();
    let mut ada = server.connect("ada");
    // Each drag starts where the shadow is by then.
    let ways = [(None, 0.0, 30.0), (Some(vec![2, 3, 4]), 30.0, 18.0), (Some(vec![1, 2]), 18.0, 21.0)];
    for (points, began, ended) in ways {
        let mut command = drag(&ada, points, ended);
        if let Command::DragFeature { from, .. } = &mut command {
            from[1] += began;
        }
        committed(&ada.edited(command));
    }
    let (_, hash) = server.state();
    let log = server.process.get("/sessions/main/log").expect("answered").text();
    let lines: Vec<Value> = log.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let drags = lines.iter().filter(|line| line["action"]["command"]["type"] == "dragFeature").count();
    let data = server.data.path().display().to_string();
    let run = |args: &[&str]| {
        let output = std::process::Command::new(program()).args(args).output().expect("it runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        output.stdout
    };
    let file = server.data.path().join("main.jsonl");
    run(&["export", "main", "--data", &data, "-o", &file.display().to_string()]);
    let replayed = |file: &std::path::Path| -> Value {
        serde_json::from_slice(&run(&["replay", &file.display().to_string(), "--resolve"])).expect("JSON")
    };
    let replay = replayed(&file);
    assert_eq!((&replay["hash"], &replay["checkpoints_ok"]), (&json!(hash), &json!(true)));
    let resolved = &replay["resolved"];
    assert_eq!((&resolved["drags"], &resolved["same"]), (&json!(drags), &json!(drags)), "{resolved}");
    assert_eq!((&resolved["drift"], &resolved["other_solver"]), (&json!(0.0), &json!(0)));

    // The planted fault: a log in which a drag led to another position. Its checkpoints no longer match, so only the
    // drift is tested.
    let text = std::fs::read_to_string(&file).expect("a log");
    let moved = text.lines().map(with_a_point_elsewhere).collect::<Vec<_>>().join("\n") + "\n";
    assert_ne!(moved, text);
    std::fs::write(&file, moved).expect("written");
    let output = std::process::Command::new(program())
        .args(["replay", &file.display().to_string(), "--resolve"])
        .output();
    let replay: Value = serde_json::from_slice(&output.expect("it runs").stdout).expect("JSON");
    let resolved = &replay["resolved"];
    assert_ne!(resolved["drift_seq"], Value::Null, "{replay}");
    assert!(resolved["drift"].as_f64().expect("a number") > 0.09, "{resolved}");
}

/// Moves the first control point of the last drag by 0.1 in its log line.
fn with_a_point_elsewhere(line: &str) -> String {
    let mut record: Value = serde_json::from_str(line).expect("JSON");
    let is_last = record["action"]["command"]["points"] == json!([1, 2]);
    let change = record["changes"].as_array_mut().and_then(|changes| changes.first_mut()).filter(|_| is_last);
    let Some(x) = change.and_then(|change| change.pointer_mut("/new/position/0")) else { return line.into() };
    *x = json!(x.as_f64().expect("a number") + 0.1);
    record.to_string()
}

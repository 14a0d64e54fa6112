//! Shadows and highlights dragged in sessions: live, pinned, recorded, replayed, and queried without an edit.

use std::path::Path;
use std::process::Command as Program;

use protocol::{
    Action, Command, Drag, DragKind, DragOutcome, DragRadii, DragStatus, ErrorCode, GestureStatus, Pin, PinKind,
    PinTarget, Record, Scope, parse_body,
};
use serde_json::{Value, json};

use crate::processes::output_of;
use crate::program::program;
use crate::sessions::support::{Mirror, Server, committed, drag_ends, ok, rejected, state_of};

const SIZE: [u32; 2] = [640, 360];
/// A pixel in the shadow of the blue vase's neck.
const SHADOW: [f64; 2] = [430.5, 265.5];

/// The drag of docs/command-line.md: moves that shadow down the table by `down` pixels.
fn drag(mirror: &Mirror, points: Option<Vec<usize>>, down: f64) -> Command {
    let camera = mirror.document.cameras().values().next().expect("the demo has a camera");
    Command::DragFeature(Box::new(Drag {
        light: mirror.light(),
        kind: DragKind::Shadow,
        points,
        radii: DragRadii::Keep,
        camera: camera.into(),
        size: SIZE,
        from: SHADOW,
        to: [SHADOW[0], SHADOW[1] + down],
        pins: None,
        alternative: None,
        alternatives: false,
        source_outside: None,
    }))
}

fn outcome(record: &Record) -> DragOutcome {
    let (Action::Edit { outcome, .. } | Action::Gesture { outcome, .. }) = &record.action else { panic!("{record:?}") };
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
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    let (seq, began) = (ada.seq, light_json(&ada));
    ada.begin("drag");
    let points = || Some(vec![2, 3, 4]);
    let mut dragged = |update: u64, down: f64| {
        ada.update("drag", update, drag(&ada, points(), down));
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
    *drag_ends(&mut off)[1] = [-9000.5, -9000.5];
    ada.update("drag", 4, off);
    let refused = state_of(&mut ada, |state| state.status.problem().is_some());
    assert_eq!((refused.update, refused.status.problem().map(|p| p.code)), (4, Some(ErrorCode::Drag)));

    ada.commit("drag");
    assert_eq!(committed(&ada.result("commit")), seq + 1);
    let record = &server.records(seq + 1)[0];
    assert_eq!(outcome(record), *landed);
    assert!(record.changes.len() == 3, "three control points: {record:?}");
    ben.catch_up(seq + 1);
    let moved = light_json(&ben);
    assert_ne!(moved, began);
    committed(&ada.undo(Scope::Mine));
    assert_eq!(light_json(&ada), began, "one step takes it back");

    // The same drag as a single edit gives the same light.
    committed(&ada.edited(drag(&ada, points(), 45.0)));
    assert_eq!(light_json(&ada), moved);
}

/// Updates that arrive faster than they are solved are skipped, except the last one.
///
/// Rules: GEST-7, GEST-1
#[test]
fn superseded_updates_are_skipped() {
    let (_server, [mut ada]) = Server::start_with(["ada"]);
    ada.begin("drag");
    let count = 300;
    for update in 1..=count {
        ada.update("drag", update, drag(&ada, None, 45.0 * update as f64 / count as f64));
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
    let (server, [mut ada, mut ben]) = Server::start_with(["ada", "ben"]);
    // The surface in the shadow.
    let query = json!([{"light": 0, "kind": "shadow", "size": SIZE, "from": SHADOW, "to": SHADOW}]);
    let at: [f64; 3] = serde_json::from_value(answers(&server, &query)[0]["fromWorld"].clone()).expect("a point");
    let pin = Pin { kind: PinKind::Direction, light: ada.light(), at: PinTarget::Point(at), caster: None, hard: true };
    committed(&ben.edited(Command::AddPin { pin: pin.clone() }));
    ada.catch_up(ben.seq);
    let id = ada.document.pins().keys().next().expect("a pin").0;
    assert_eq!(protocol::Document::from(&ada.document).pins[0].pin, pin);

    // One control point cannot direct the light path to the cursor and keep its direction here: the answer names the
    // pin.
    let command = drag(&ada, Some(vec![3]), 20.0);
    let began = light_json(&ada);
    let answer = ada.edited(command.clone());
    let refused = rejected(&answer);
    assert_eq!(refused.code, ErrorCode::Drag);
    assert!(refused.message.contains("its pin “Direction” holds the feature back"), "{}", refused.message);
    assert_eq!(light_json(&ada), began);

    // No client can pin a light that another one drags.
    ada.begin("drag");
    ada.update("drag", 1, drag(&ada, None, 5.0));
    state_of(&mut ada, |state| state.update == 1);
    assert_eq!(rejected(&ben.edited(Command::AddPin { pin })).code, ErrorCode::Locked);
    ada.cancel("drag");
    state_of(&mut ben, |state| matches!(state.status, GestureStatus::Cancelled { .. }));

    // Without the pin the same drag lands.
    committed(&ben.edited(Command::RemovePin { pin: id }));
    ada.catch_up(ben.seq);
    committed(&ada.edited(command));
    assert_eq!(outcome(&server.records(ada.seq)[0]).status, DragStatus::Landed);
}

/// Results of drags that edit nothing.
fn answers(server: &Server, drags: &Value) -> Vec<Value> {
    parse_body(&ok(server.post("/sessions/main/drags", drags)).text()).expect("an array")
}

/// Rules: HTTP-23, DRAG-2, DRAG-4
#[test]
fn programs_ask_where_drags_would_lead() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    let (seq, hash) = server.state();
    let one = json!({"light": "key", "kind": "shadow", "points": [2, 3, 4], "size": SIZE, "from": SHADOW, "to": [430.5, 310.5]});
    let other =
        json!({"light": 0, "kind": "hotspot", "size": SIZE, "from": [300.5, 300.5], "to": [320.5, 310.5], "camera": 0});
    let there = answers(&server, &json!([one, other]));
    let back = answers(&server, &json!([other, one]));
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
    let output = Program::new(program()).arg("drag").arg("demo:vases").arg(&file).output();
    let printed: Vec<Value> = serde_json::from_slice(&output.expect("it runs").stdout).expect("JSON");
    assert_eq!(without_seconds(&printed[0]), without_seconds(&there[0]));

    // The document's pins apply unless the request has its own.
    let at = there[0]["fromWorld"].clone();
    let pin = json!({"kind": "lit", "light": ada.light(), "at": at, "hard": true});
    committed(&ada.edited(serde_json::from_value(json!({"type": "addPin", "pin": pin})).expect("a command")));
    let id = ada.document.pins().keys().next().expect("a pin").0;
    let refused = answers(&server, &json!([one]));
    assert_eq!((&refused[0]["status"], &refused[0]["reason"]), (&json!("refused"), &json!("pinDoesNotHold")));
    assert_eq!(refused[0]["pin"], id);
    let mut free = one.clone();
    free["pins"] = json!([]);
    assert_eq!(answers(&server, &json!([free]))[0]["status"], "landed");

    let with = |field: &str, value: Value| {
        let mut drag = json!({"light": 0, "kind": "shadow", "size": SIZE, "from": SHADOW, "to": SHADOW});
        drag[field] = value;
        json!([drag])
    };
    for (wrong, code) in [
        (with("light", json!("nobody")), "notFound"),
        (with("camera", json!("none")), "notFound"),
        (with("size", json!([0, 9])), "drag"),
        (with("size", json!([99999, 9])), "tooLarge"),
        (with("kind", json!("glow")), "badMessage"),
        (json!({}), "badMessage"),
    ] {
        let refused = server.post("/sessions/main/drags", &wrong);
        let error: protocol::ErrorBody = parse_body(&refused.text()).expect("an error");
        assert_eq!(error.error.code.name(), code, "{wrong}: {}", refused.text());
    }
}

/// Replay uses the recorded values; with `--resolve` it solves again and reports the difference.
///
/// Rules: REC-2, REC-7
#[test]
fn a_log_is_solved_again() {
    let (server, [mut ada]) = Server::start_with(["ada"]);
    // Each drag starts where the shadow is by then.
    for (points, began, ended) in [(None, 0.0, 30.0), (Some(vec![2, 3, 4]), 30.0, 18.0), (Some(vec![1, 2]), 18.0, 21.0)]
    {
        let mut command = drag(&ada, points, ended);
        drag_ends(&mut command)[0][1] += began;
        committed(&ada.edited(command));
    }
    let (_, hash) = server.state();
    let is_drag = |record: &&Record| matches!(record.action, Action::Edit { command: Command::DragFeature(_), .. });
    let drags = server.records(0).iter().filter(is_drag).count();
    let file = server.data.path().join("main.jsonl");
    let mut export = Program::new(program());
    output_of(export.args(["export", "main", "--data"]).arg(server.data.path()).arg("-o").arg(&file));
    let replayed = |file: &Path| Program::new(program()).arg("replay").arg(file).arg("--resolve").output();
    let output = replayed(&file).expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let replay: Value = serde_json::from_slice(&output.stdout).expect("JSON");
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
    let replay: Value = serde_json::from_slice(&replayed(&file).expect("it runs").stdout).expect("JSON");
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

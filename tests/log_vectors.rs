//! Test vectors for readers of the log that are written from SPEC alone, such as `protocol/examples/replay.py`: logs
//! with every kind of value, and their results. `BENDYLIGHTS_BLESS=1` writes them again, once per format.

use std::path::{Path, PathBuf};
use std::process::{Command as Process, Output};

use document::{CommandContext, SceneContents};
use edit::{Actor, EditRequest, EditSources, Session, UndoScope};
use serde_json::{Value, json};
use store::{CommitBatch, Store, replay_log};

use crate::sources::repository;

/// Steps of a session: commands in JSON, `"undo"` and `"redo"`, and the records after which a checkpoint may follow.
struct Vector {
    name: &'static str,
    steps: fn() -> Vec<Value>,
}

const VECTORS: [Vector; 3] = [
    Vector { name: "lights", steps: lights },
    Vector { name: "cameras-and-pins", steps: cameras_and_pins },
    Vector { name: "long-values", steps: long_values },
];

fn bendy(name: &str, points: usize) -> Value {
    let along = |i: usize| [0.01 * i as f64 * i as f64 / points as f64, -0.0, -0.5 * i as f64];
    json!({
        "type": "bendy",
        "name": name,
        "points": (0..points).map(along).collect::<Vec<_>>(),
        "radii": (0..points).map(|i| 0.1 + 0.02 * i as f64).collect::<Vec<_>>(),
    })
}

fn add(light: &Value) -> Value {
    json!({"type": "addLight", "light": light})
}

fn set(target: &str, value: &Value) -> Value {
    json!({"type": "set", "target": target, "value": value})
}

/// Every type of light, every kind of parameter, absent and given, and every change of a light.
fn lights() -> Vec<Value> {
    vec![
        add(&bendy("key", 5)),
        add(&json!({"type": "spot", "name": "lämp", "range": 8, "coneAngle": 40, "intensity": -0.0})),
        add(&json!({"type": "omni", "name": "bulb", "transform": {"translation": [1, 2.5, -0.0]}})),
        add(&json!({"type": "directional", "name": "sun", "width": 4, "height": 3})),
        set("/lights/1/coneAngle", &json!(30.5)),
        set("/lights/1/points/2/radius", &json!(0.25)),
        set("/lights/1/points/2/color", &json!([1.0, 0.5, 0.25])),
        set("/lights/1/points/3/intensity", &json!(2.5)),
        set("/lights/1/enabled", &json!(false)),
        set("/lights/1/crossSection", &json!("superellipse")),
        set("/lights/1/radialFalloff", &json!([[0, 1], [90, 0.5], [200.5, 0.75]])),
        set("/lights/1/lightLink", &json!({"include": ["room/b", "room/a", "room/a"], "exclude": []})),
        set("/lights/2/shadowLink", &json!({"exclude": ["room/ö"]})),
        set("/lights/2/cutOff", &json!(6)),
        set("/lights/2/range", &json!(null)),
        set("/lights/2/translation", &json!([0.1, 1e-7, 1e14])),
        set("/lights/2/rotation", &json!([0, 0, 1, 0])),
        set("/lights/2/name", &json!("\"lamp\" \\ \u{1F4A1}")),
        "undo".into(),
        "redo".into(),
        set("/lights/3/colorTemperature", &json!(3200)),
        set("/lights/3/enableColorTemperature", &json!(true)),
        set("/lights/4/width", &json!(null)),
        json!({"type": "insertPoint", "light": 1, "point": 2}),
        json!({"type": "removePoint", "light": 1, "point": 4}),
        json!({"type": "bendLight", "light": 2, "segments": 3}),
        json!({"type": "straightenLight", "light": 1}),
        "undo".into(),
        json!({"type": "removeLight", "light": 3}),
    ]
}

/// Both projections with and without their optional fields, and pins of each kind.
fn cameras_and_pins() -> Vec<Value> {
    let camera = |name: &str, projection: &Value| {
        json!({"type": "addCamera", "camera": {
            "name": name, "translation": [0, 1.5, 4], "rotation": [0, 0, 0, 1], "projection": projection,
        }})
    };
    let pin = |more: &Value| {
        let mut pin = json!({"light": 1, "at": [0.5, -0.0, 1e-300], "hard": true});
        pin.as_object_mut().expect("an object").extend(more.as_object().expect("an object").clone());
        json!({"type": "addPin", "pin": pin})
    };
    vec![
        add(&bendy("key", 3)),
        camera("plain", &json!({"perspective": {"yfov": 0.7, "znear": 0.1}})),
        camera("whole", &json!({"perspective": {"yfov": 0.7, "aspectRatio": 2.39, "znear": 0.1, "zfar": 100}})),
        camera("flat", &json!({"orthographic": {"ymag": 2, "znear": 0, "zfar": 50}})),
        camera("wide", &json!({"orthographic": {"ymag": 2, "aspectRatio": 1.85, "znear": 0, "zfar": 50}})),
        json!({"type": "placeCamera", "camera": 2, "translation": [1, 2, 3]}),
        json!({"type": "setCamera", "camera": 3, "parameter": {"name": "renamed"}}),
        pin(&json!({"kind": "direction"})),
        pin(&json!({"kind": "lit", "hard": false})),
        pin(&json!({"kind": "shadowed"})),
        pin(&json!({"kind": "shadow", "caster": "room/vase"})),
        pin(&json!({"kind": "look", "at": "room/vase"})),
        pin(&json!({"kind": "coordinates", "at": "", "hard": false})),
        json!({"type": "setPin", "pin": 6, "hard": false}),
        json!({"type": "removePin", "pin": 8}),
        json!({"type": "removeCamera", "camera": 4}),
    ]
}

/// Lights with so many control points that a record refers to values of earlier records and to its own.
fn long_values() -> Vec<Value> {
    vec![
        add(&bendy("long", 90)),
        json!({"type": "insertPoint", "light": 1, "point": 40}),
        "undo".into(),
        json!({"type": "insertPoint", "light": 1, "point": 41}),
        json!({"type": "removeLight", "light": 1}),
        "undo".into(),
        set("/lights/1/points/7/radius", &json!(0.3)),
        add(&bendy("again", 90)),
    ]
}

/// Makes the log of a vector, and returns the session after it.
fn made(vector: &Vector) -> (String, Session) {
    let folder = tempfile::tempdir().expect("a folder");
    let mut store = Store::create(folder.path()).expect("a store");
    store.create_session(vector.name).expect("a new name");
    let (mut session, mut records) = (Session::default(), Vec::new());
    for step in (vector.steps)() {
        let request = match step.as_str() {
            Some("undo") => EditRequest::Undo(UndoScope::Mine),
            Some(_) => EditRequest::Redo(UndoScope::Mine),
            None => {
                let command: protocol::Command = serde_json::from_value(step.clone()).expect("a command");
                EditRequest::Edit { base_seq: None, command: command.try_into().expect("a sound command") }
            }
        };
        let seq = session.seq() + 1;
        let is_graces = seq % 4 == 3 && !step.is_string();
        let (id, name) = if is_graces { ("grace", "Grace") } else { ("ada", "Ada") };
        let actor = Actor { id: id.into(), name: name.into() };
        let record = |seq: u64| records.get(seq as usize - 1).cloned();
        let reverted = session.find_revert(&request, &actor.id, &record).expect("something to take back");
        let contents = SceneContents::default();
        let context = CommandContext { loaded: Some(&contents), ..CommandContext::default() };
        let sources = EditSources { context, reverted };
        let made = session.execute_request(request, &actor, &format!("op {seq}"), 1_790_000_000_000 + seq, sources);
        let record = made.unwrap_or_else(|refused| panic!("{step}: {refused}"));
        let hash = session.document().hash();
        records.push(record);
        let added = &records[records.len() - 1..];
        store.append(&[CommitBatch { session: vector.name, records: added, rejections: &[], hash }]).expect("a commit");
    }
    let mut text = Vec::new();
    store.export(vector.name, &mut text).expect("a log");
    (String::from_utf8(text).expect("text"), session)
}

fn folder() -> PathBuf {
    repository().join("protocol/vectors/logs")
}

/// Tests that the committed file equals `made`.
fn agrees(name: &str, made: &str) {
    let path = folder().join(name);
    if std::env::var_os("BENDYLIGHTS_BLESS").is_some() {
        std::fs::create_dir_all(folder()).expect("a folder");
        std::fs::write(&path, made).expect("written");
    }
    let committed = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(committed == made, "{name} is not what the code makes: run this test with BENDYLIGHTS_BLESS=1");
}

/// Last checkpoint of a log.
fn last_checkpoint(text: &str) -> Value {
    let mut line: Value = serde_json::from_str(text.lines().last().expect("lines")).expect("a checkpoint");
    line["checkpoint"].take()
}

/// Results of a vector: the hash, the proof and the document.
fn outcome(text: &str, session: &Session) -> Value {
    json!({
        "records": session.seq(),
        "hash": session.document().hash().to_string(),
        "proof": last_checkpoint(text)["proof"],
        "document": protocol::Document::from(session.document()),
    })
}

/// Rules: DOC-4, LOG-1, LOG-2, LOG-4
#[test]
fn vectors_are_what_the_program_makes_and_replay_to_what_they_say() {
    for vector in &VECTORS {
        let (text, session) = made(vector);
        agrees(&format!("{}.jsonl", vector.name), &text);
        let outcome = serde_json::to_string_pretty(&outcome(&text, &session)).expect("plain data");
        agrees(&format!("{}.json", vector.name), &(outcome + "\n"));
        let replayed = replay_log(text.as_bytes(), None).expect(vector.name);
        assert_eq!(replayed.first_difference, None, "{}", vector.name);
        assert_eq!(replayed.session.document().hash(), session.document().hash());
    }
    assert!(made(&VECTORS[2]).0.contains("sameAs"), "long values are referred to");
}

fn replay_py(log: &Path) -> Output {
    let script = repository().join("protocol/examples/replay.py");
    Process::new("python3").arg(script).arg(log).output().expect("python3: `apt-get install python3` brings it")
}

/// The newest permanent log of `tests/logs`, and the vectors.
fn newest_logs() -> Vec<PathBuf> {
    let mut logs: Vec<_> = VECTORS.iter().map(|vector| folder().join(format!("{}.jsonl", vector.name))).collect();
    logs.extend([3, 4, 5].map(|format| repository().join(format!("tests/logs/format-{format}.jsonl"))));
    logs
}

/// Rules: DOC-4, REC-3, REC-6, LOG-1, LOG-4
#[test]
#[ignore = "needs Python"]
fn a_reader_written_from_the_specification_reaches_every_hash_and_proof() {
    for log in newest_logs() {
        let done = replay_py(&log);
        let said: Value = serde_json::from_slice(&done.stdout).unwrap_or_default();
        let why = String::from_utf8_lossy(&done.stderr);
        let text = std::fs::read_to_string(&log).expect("a log");
        let last = last_checkpoint(&text);
        let count = text.lines().filter(|line| line.starts_with("{\"checkpoint\"")).count();
        for (field, expected) in [("hash", &last["hash"]), ("proof", &last["proof"]), ("checkpoints", &json!(count))] {
            assert_eq!(&said[field], expected, "{field} of {}: {why}", log.display());
        }
    }
}

/// A change of a log's lines.
type Fault = fn(&mut Vec<String>);

/// Both readers detect planted faults and name the record.
///
/// Rules: REC-1, REC-3, LOG-1, LOG-4
#[test]
#[ignore = "needs Python"]
fn planted_faults_are_told_apart() {
    let scratch = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(folder().join("lights.jsonl")).expect("a vector");
    let faults: [(&str, Fault, &str, &str); 5] = [
        (
            "a value",
            |l| replace(l, 4, "\"height\":3.0", "\"height\":3.5"),
            "the document after record",
            "the document after record",
        ),
        (
            "a name",
            |l| replace(l, 15, "Grace", "Grady"),
            "a line of records 11 to 20",
            "they were right up to record 10",
        ),
        ("the header", |l| replace(l, 0, "lights", "lambs"), "the header or a line", "the lines up to record 10"),
        ("a line's end", |l| l[3].push('\r'), "CR LF", "CR LF"),
        ("two records swapped", |l| l.swap(3, 4), "record 4 follows record 2", "out of order"),
    ];
    for (what, plant, ours, theirs) in faults {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        let before = lines.clone();
        plant(&mut lines);
        assert_ne!(lines, before, "{what}");
        let planted = lines.join("\n") + "\n";
        let said = match replay_log(planted.as_bytes(), None) {
            Ok(replayed) => replayed.first_difference.expect(what).to_string(),
            Err(error) => error.to_string(),
        };
        assert!(said.contains(ours), "{what}: {said}");
        let log = scratch.path().join("planted.jsonl");
        std::fs::write(&log, planted).expect("a file");
        let done = replay_py(&log);
        let said = String::from_utf8_lossy(&done.stderr).into_owned();
        assert!(!done.status.success() && said.contains(theirs), "{what}: {said}");
    }
}

/// Replaces all of `was` in the line of record `seq`, 0 for the header.
fn replace(lines: &mut [String], seq: u64, was: &str, now: &str) {
    let of_record = |line: &&mut String| match seq {
        0 => !line.contains("\"seq\""),
        _ => line.contains(&format!("\"seq\":{seq},\"timeMs\"")),
    };
    let line = lines.iter_mut().find(of_record).expect("a record");
    assert!(line.contains(was), "{line}");
    *line = line.replace(was, now);
}

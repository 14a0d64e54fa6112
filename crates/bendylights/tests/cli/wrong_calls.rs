//! Tests of wrong calls, in one table with the message for each: `wrong_calls.txt`, which people should read
//! through.
//!
//! With `BENDYLIGHTS_BLESS=1` the test writes the table anew.

use std::fmt::Write as _;
use std::process::{Command, Stdio};
use std::{env, fs};

use serde_json::{Value, json};

use crate::program::{BENDY, Folder, SPOT, TRIANGLE, binary, run};

const TABLE: &str = include_str!("wrong_calls.txt");
const LOG: &str = include_str!("../../../../tests/logs/format-4.jsonl");

/// Returns the folder in which the calls run.
fn folder() -> Folder {
    let folder = Folder::new();
    folder.file("room.gltf", TRIANGLE);
    folder.file("spot.json", SPOT);
    folder.file("bent.json", BENDY);
    folder.file("two.json", format!("[{SPOT}, {BENDY}]"));
    folder.file("broken.json", r#"{"type": "spot", "#);
    folder.file("laser.json", r#"{"type": "laser"}"#);
    folder.file("wide.json", r#"{"type": "spot", "coneAngle": 95}"#);
    folder.file("points.json", "[[0, 0]]");
    folder.file("notes.txt", "Nothing but words.\n");
    folder.file("drags.json", r#"[{"light": "lamp", "drag": "shadows"}]"#);
    folder.file("log.jsonl", LOG);
    folder.file("cut.jsonl", LOG.lines().take(20).map(|line| line.to_owned() + "\n").collect::<String>());
    let swapped = LOG.replacen("\"seq\":5,", "\"seq\":6,", 1);
    folder.file("swapped.jsonl", swapped);
    folder.file("newer.jsonl", LOG.replacen("\"format\":4", "\"format\":99", 1));
    folder.file("broken.zip", b"PK\x03\x04 and then nothing");
    fs::create_dir(folder.path("empty")).expect("a folder");
    let imported = run(&["import", &folder.path("log.jsonl"), "--data", &folder.path("data")]);
    assert_eq!(imported.code, 0, "{}", imported.stderr);
    folder
}

/// Returns the calls in the table, without the program's name.
fn calls() -> Vec<&'static str> {
    TABLE.lines().filter_map(|line| line.strip_prefix("$ bendylights ")).collect()
}

/// Returns the table's entry for a call: the call, its exit code and its message.
fn entry(folder: &Folder, call: &str) -> String {
    let mut command = Command::new(binary());
    command.args(call.split(' ')).current_dir(folder.path("")).stdin(Stdio::null());
    let output = command.env("RUST_LOG", "off").output().expect("the binary runs");
    let said = String::from_utf8(output.stderr).expect("UTF-8");
    assert_eq!(output.stdout, b"", "{call}: an answer");
    // Notes depend on the scene and on the machine.
    let said: Vec<_> = said.lines().filter(|line| !line.is_empty() && !line.starts_with("note: ")).collect();
    format!("$ bendylights {call}\n{} {}\n", output.status.code().expect("no signal"), said.join("\n  "))
}

/// Returns the fault of an entry, whatever its message.
fn fault(entry: &str) -> Option<&'static str> {
    let said = entry.split_once('\n').expect("a call").1;
    let (code, why) = said.split_once(' ').unwrap_or((said, ""));
    let is_json = why.starts_with("{\"error\": ") || why.starts_with("{\"error\":{");
    if !matches!(code, "1" | "2") {
        Some("neither 1 nor 2")
    } else if !is_json && !why.starts_with("error: ") {
        Some("no sentence")
    } else if why.contains("panicked") || why.contains("RUST_BACKTRACE") {
        Some("a panic")
    } else {
        None
    }
}

#[test]
fn each_wrong_call_gets_its_sentence_and_exit_code() {
    let folder = folder();
    let before = folder.names();
    let calls = calls();
    assert!(calls.len() >= 80, "{} calls", calls.len());
    let mut table = String::from(
        "Wrong calls, each with its exit code and what is said, in a folder with a scene, light files and a log.\n\
         2: the call is wrong and can be mended. 1: this machine prevents it.\n\n",
    );
    for call in calls {
        let entry = entry(&folder, call);
        assert_eq!(fault(&entry), None, "{entry}");
        writeln!(table, "{entry}").expect("to a string");
    }
    assert_eq!(folder.names(), before, "none leaves anything");
    if env::var_os("BENDYLIGHTS_BLESS").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cli/wrong_calls.txt");
        fs::write(path, table).expect("written");
    } else {
        for (found, expected) in table.split("\n\n").zip(TABLE.split("\n\n")) {
            assert_eq!(found, expected);
        }
        assert_eq!(table.len(), TABLE.len());
    }
    assert!(fault("$ bendylights x\n101 thread 'main' panicked at").is_some(), "a planted fault");
}

#[test]
fn with_json_a_failure_is_an_object() {
    let folder = folder();
    for call in [&["--json", "render", "nowhere.glb", "-o", "x.png"][..], &["render", "--size", "big", "--json"]] {
        let done = run(call);
        let said: Value = serde_json::from_str(&done.stderr).expect("one object");
        assert_eq!((done.code, &said["error"]["exitCode"]), (2, &json!(2)), "{said}");
        let why = said["error"]["message"].as_str().expect("a sentence");
        assert!(why.contains("nowhere.glb") || why.contains("big"), "{why}");
        assert!(!why.starts_with("error") && !why.contains("--help"), "{why}");
    }
    let listed = run(&["--json", "sessions", "--data", &folder.path("data")]);
    let listed: Value = serde_json::from_str(&listed.stdout).expect("JSON");
    assert_eq!(listed[0]["name"], json!("old"));
}

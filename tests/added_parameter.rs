//! Tests that one row of the parameter table is enough: a parameter that exists in this test only is set, refused,
//! undone, hashed, exported, replayed, and is in the schemas and on the page, without any other code for it.

#[path = "browser.rs"]
mod browser;
#[path = "in_process.rs"]
mod in_process;
#[path = "program.rs"]
mod program;

use std::ops::Bound::Included;
use std::process::Command;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

use bench::ServerAddress;
use browser::run_in_browser;
use in_process::InProcessServer;
use light::{NumberRange, Parameter, ParameterKind, ParameterOf, ParameterOwner, ParameterTouches, Value};
use program::program;
use protocol::{SchemaSide, json_schema};
use serde_json::{Value as Json, json};
use store::{Store, replay_log};
use tokio::runtime::Runtime;

const fn dimmed(owner: ParameterOwner) -> ParameterOf {
    ParameterOf { owner, default: Some(Value::Number(1.0)), touches: ParameterTouches::Radiance }
}

static DIMMER: Parameter = Parameter {
    name: "dimmer",
    path: "dimmer",
    owners: &[dimmed(ParameterOwner::Spot), dimmed(ParameterOwner::Bendy)],
    kind: ParameterKind::Number(NumberRange {
        unit: "times",
        min: Included(0.0),
        max: Included(8.0),
        slider: Some([0.0, 2.0]),
        ..NumberRange::ANY
    }),
    animates: true,
    needs: None,
    group: "Test",
    label: "Dimmer",
    doc: "A row that only a test has.",
};

/// Adds the row before any code reads the table.
static ADDED: LazyLock<()> = LazyLock::new(|| assert!(light::add_parameters(&[&DIMMER]), "looked at already"));

/// A server with that row, in this process.
struct ParameterServer {
    runtime: Runtime,
    address: ServerAddress,
    data: tempfile::TempDir,
}

impl ParameterServer {
    fn start() -> Self {
        LazyLock::force(&ADDED);
        let data = tempfile::tempdir().expect("a folder");
        let InProcessServer { runtime, address } = InProcessServer::start(data.path(), None);
        Self { runtime, address, data }
    }

    fn get(&self, path: &str) -> Json {
        serde_json::from_str(&self.address.get(path).expect("answered").text()).expect("JSON")
    }

    /// Outcome of one edit.
    fn edited(&self, edit: &Json) -> Json {
        let body = json!({"edits": [edit]}).to_string();
        let answer = self.address.post("/sessions/main/edits", body.as_bytes()).expect("answered").text();
        serde_json::from_str::<Json>(&answer).expect("JSON")["results"][0].take()
    }

    fn set(&self, target: &str, value: f64) -> Json {
        self.edited(&json!({"command": {"type": "set", "target": target, "value": value}}))
    }

    /// Hash of the document, and the row's value of the demo's light.
    fn state(&self) -> (String, Json) {
        let mut state = self.get("/sessions/main");
        let hash = state["hash"].as_str().expect("a hash").to_owned();
        (hash, state["document"]["lights"][0]["light"]["dimmer"].take())
    }

    fn log(&self) -> String {
        let mut log = Vec::new();
        Store::open(self.data.path()).expect("a store").export("main", &mut log).expect("a log");
        String::from_utf8(log).expect("text")
    }
}

/// Rules: CMD-8, CMD-9, DOC-4, HTTP-19, LOG-1, LOG-2, UNDO-4
#[test]
fn a_row_is_all_that_a_parameter_needs() {
    let own = ParameterServer::start();
    let (unset, default) = own.state();
    assert_eq!(default, json!(1.0), "a light that says nothing has the default");

    let target = "/lights/1/dimmer";
    assert_eq!(own.set(target, 0.25)["status"], "committed");
    let (set, value) = own.state();
    assert_eq!(value, json!(0.25));
    assert_ne!(set, unset, "the hash covers it");
    let set_light = json!({"type": "setLight", "light": 1, "parameter": {"dimmer": 0.5}});
    assert_eq!(own.edited(&json!({"command": set_light}))["status"], "committed");

    let refused = own.set(target, 9.0);
    assert_eq!((&refused["status"], &refused["code"]), (&json!("rejected"), &json!("invalidLight")));
    let sentence = refused["message"].as_str().expect("a sentence");
    for words in ["`dimmer`", "9", "from 0 to 8 times"] {
        assert!(sentence.contains(words), "`{words}` is missing from: {sentence}");
    }
    let refused = own.edited(&json!({"command": {"type": "set", "target": target, "value": "dim"}}));
    assert_eq!(refused["code"], "badMessage");

    for _ in 0..2 {
        assert_eq!(own.edited(&json!({"undo": "mine"}))["status"], "committed");
    }
    assert_eq!(own.state(), (unset, json!(1.0)), "undone, it leaves no trace in the document");
    assert_eq!(own.edited(&json!({"redo": "mine"}))["status"], "committed");
    assert_eq!(own.state(), (set.clone(), json!(0.25)));

    let log = own.log();
    assert!(log.contains(r#"{"dimmer":0.25}"#), "exported: {log}");
    let replayed = replay_log(log.as_bytes(), None).expect("a sound log");
    assert_eq!((replayed.first_difference, replayed.session.document().hash().to_string()), (None, set.clone()));
    // The planted fault: a different value.
    let planted = replay_log(log.replace(r#"{"dimmer":0.25}"#, r#"{"dimmer":0.75}"#).as_bytes(), None);
    assert!(planted.expect("the same records").first_difference.is_some());
    // The control: the program as it ships has no such row and reports it.
    let file = own.data.path().join("log.jsonl");
    std::fs::write(&file, &log).expect("a file");
    let shipped = Command::new(program()).arg("replay").arg(&file).output().expect("it runs");
    let said = String::from_utf8_lossy(&shipped.stderr);
    assert!(!shipped.status.success() && said.contains("dimmer"), "{said}");

    let other = tempfile::tempdir().expect("a folder");
    let mut store = Store::create(other.path()).expect("a store");
    let row = store.import(log.as_bytes(), None, &|_| true).expect("imported");
    assert_eq!(row.hash, set);

    own.runtime.shutdown_timeout(Duration::from_secs(10));
}

/// Rules: HTTP-18, HTTP-19
#[test]
fn a_row_is_in_every_schema_and_in_the_table() {
    let own = ParameterServer::start();
    for face in [SchemaSide::Read, SchemaSide::Written] {
        let schema = json_schema(face);
        for light in ["Bendy", "Spot"] {
            let dimmer = &schema["$defs"][light]["properties"]["dimmer"];
            assert_eq!((&dimmer["minimum"], &dimmer["maximum"]), (&json!(0.0), &json!(8.0)), "{light}");
            assert_eq!(dimmer["default"], json!(1.0), "{light}");
        }
        assert!(schema["$defs"]["LightDimmer"].is_object(), "as a parameter of `setLight`");
    }
    let openapi = own.get("/openapi.json");
    assert!(openapi["components"]["schemas"]["LightDimmer"].is_object());
    let table = own.get("/parameters");
    let rows = table["parameters"].as_array().expect("rows");
    let row = rows.iter().find(|row| row["name"] == "dimmer").expect("its row");
    assert_eq!(row["address"]["bendy"], "/lights/ID/dimmer");
    assert_eq!(row["kind"]["max"], json!(8.0));
    own.runtime.shutdown_timeout(Duration::from_secs(10));
}

/// Rules: CMD-9, HTTP-19
#[test]
#[ignore = "needs the page and a browser: make page test-packages"]
fn a_row_is_a_field_on_the_page() {
    let own = ParameterServer::start();
    let until = Instant::now() + Duration::from_mins(3);
    while own.address.get("/readyz").expect("answered").status != 200 {
        assert!(Instant::now() < until, "it gets ready");
        std::thread::sleep(Duration::from_millis(50));
    }
    run_in_browser("added_parameter.mjs", &own.address, Some("main"), None);
    own.runtime.shutdown_timeout(Duration::from_secs(10));
}

//! Tests that `/openapi.json` is enough to generate a client.

use std::path::{Path, PathBuf};
use std::process::Command;

use bench::ServerProcess;
use serde_json::{Value, json};

use crate::program::program;

/// Folder of the tools of `tests/openapi/requirements.txt`.
fn tools() -> PathBuf {
    let tools = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/openapi-tools");
    assert!(tools.join("installed").is_file(), "`make openapi-tools` installs what this test needs");
    tools.join("bin")
}

/// Runs a program. Returns its output as the error if it fails.
fn run(command: &mut Command) -> Result<(), String> {
    let output = command.output().expect("it runs");
    let said = [output.stdout, output.stderr].concat();
    if output.status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&said).into_owned()) }
}

fn validate(tools: &Path, document: &Value, folder: &Path) -> Result<(), String> {
    let path = folder.join("openapi.json");
    std::fs::write(&path, document.to_string()).expect("written");
    run(Command::new(tools.join("openapi-spec-validator")).arg("--schema").arg("3.1").arg(path))
}

/// Rules: HTTP-18
#[test]
#[ignore = "needs the tools for OpenAPI: make openapi-tools"]
fn the_document_is_valid_and_a_generated_client_bends_a_light() {
    let tools = tools();
    let (data, folder) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let server = ServerProcess::start(program(), data.path(), &["--scene", "demo:vases"]).expect("started");
    let document = server.get("/openapi.json").expect("answered").text();
    let document: Value = serde_json::from_str(&document).expect("JSON");
    let faults = [
        ("/components/schemas/SetPoint/type", json!("objekt")),
        ("/components/schemas/Spot/properties/intensity/default", json!("bright")),
        ("/paths/~1sessions/post/responses/201", json!({"content": {}})),
        ("/paths/~1sessions~1{session}/get/parameters", json!([])),
    ];
    for (place, fault) in faults {
        let mut planted = document.clone();
        *planted.pointer_mut(place).expect(place) = fault;
        assert!(validate(&tools, &planted, folder.path()).is_err(), "a planted fault is caught: {place}");
    }
    validate(&tools, &document, folder.path()).unwrap_or_else(|said| panic!("{said}"));

    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("openapi");
    let mut generator = Command::new(tools.join("openapi-python-client"));
    generator.args(["generate", "--meta", "none", "--fail-on-warning", "--path"]);
    generator.arg(folder.path().join("openapi.json")).arg("--config").arg(own.join("generator.yaml"));
    generator.arg("--output-path").arg(folder.path().join("bendylights_client"));
    run(&mut generator).unwrap_or_else(|said| panic!("{said}"));

    server.wait_until_ready().expect("ready");
    let (url, token) = (format!("http://{}", server.address.host), server.address.token.as_str());
    let bend = |token: &str| {
        let mut script = Command::new(tools.join("python"));
        script.arg(own.join("bend.py")).args([&url, token]).env("PYTHONPATH", folder.path());
        run(script.env("PYTHONDONTWRITEBYTECODE", "1"))
    };
    bend(token).unwrap_or_else(|said| panic!("{said}"));
    let refused = bend("0123456789abcdef0123456789abcdef").expect_err("another server's token");
    assert!(refused.contains("UNAUTHORIZED"), "the refusal comes as a type: {refused}");
}

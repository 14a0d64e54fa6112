//! Tests that `/openapi.json` is enough to generate a client.

use std::path::Path;
use std::process::{Command, Output};

use serde_json::{Value, json};

use crate::processes::{openapi_tool, serve};
use crate::sessions::support::DEMO;
use crate::sources::repository;

/// Runs a program. Returns its output as the error if it fails.
fn run(command: &mut Command) -> Result<(), String> {
    let Output { status, stdout, stderr } = command.output().expect("it runs");
    if status.success() { Ok(()) } else { Err(String::from_utf8_lossy(&[stdout, stderr].concat()).into_owned()) }
}

fn validate(document: &Value, folder: &Path) -> Result<(), String> {
    let path = folder.join("openapi.json");
    std::fs::write(&path, document.to_string()).expect("written");
    run(Command::new(openapi_tool("openapi-spec-validator")).arg("--schema").arg("3.1").arg(path))
}

/// Rules: HTTP-18
#[test]
#[ignore = "needs the tools for OpenAPI: make openapi-tools"]
fn the_document_is_valid_and_a_generated_client_bends_a_light() {
    let is_installed = openapi_tool("../installed").is_file();
    assert!(is_installed, "`make openapi-tools` installs what this test needs");
    let (data, folder) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let server = serve(data.path(), DEMO);
    let document = server.get("/openapi.json").expect("answered").text();
    let document: Value = serde_json::from_str(&document).expect("JSON");
    let faults = [
        ("/components/schemas/SetPoint/type", json!("objekt")),
        ("/components/schemas/Spot/properties/intensity/default", json!("bright")),
        ("/paths/~1sessions/post/responses/201", json!({"content": {}})),
        ("/paths/~1sessions~1{session}/get/parameters", json!([])),
    ];
    for (pointer, fault) in faults {
        let mut planted = document.clone();
        *planted.pointer_mut(pointer).expect(pointer) = fault;
        assert!(validate(&planted, folder.path()).is_err(), "a planted fault is caught: {pointer}");
    }
    validate(&document, folder.path()).unwrap_or_else(|said| panic!("{said}"));

    let own = repository().join("tests/openapi");
    let mut generator = Command::new(openapi_tool("openapi-python-client"));
    generator.args(["generate", "--meta", "none", "--fail-on-warning", "--path"]);
    generator.arg(folder.path().join("openapi.json")).arg("--config").arg(own.join("generator.yaml"));
    generator.arg("--output-path").arg(folder.path().join("bendylights_client"));
    run(&mut generator).unwrap_or_else(|said| panic!("{said}"));

    let (url, token) = (format!("http://{}", server.address.host), server.address.token.as_str());
    let bend = |token: &str| {
        let mut script = Command::new(openapi_tool("python"));
        script.arg(own.join("bend.py")).args([&url, token]).env("PYTHONPATH", folder.path());
        run(script.env("PYTHONDONTWRITEBYTECODE", "1"))
    };
    bend(token).unwrap_or_else(|said| panic!("{said}"));
    let refused = bend("0123456789abcdef0123456789abcdef").expect_err("another server's token");
    assert!(refused.contains("UNAUTHORIZED"), "the refusal comes as a type: {refused}");
}

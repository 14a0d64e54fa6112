//! Reads EXR files with other programs.

use std::path::Path;
use std::process::{Command, Output};

use glam::{DMat4, DQuat, DVec3};
use serde_json::{Value, json};

use crate::processes::{openapi_tool, output_of};
use crate::program::program;
use crate::sources::repository;

/// Tests with OpenEXR's library and `OpenImageIO` that a file has the expected contents.
fn reads(file: &Path, expected: &Value) -> Output {
    let expectation = file.with_extension("json");
    std::fs::write(&expectation, expected.to_string()).expect("a file");
    let mut python = Command::new(openapi_tool("python3"));
    python.arg(repository().join("tests/exr/read.py")).arg(file).arg(expectation).output().expect("python runs")
}

/// Rules: HTTP-30
#[test]
#[ignore = "needs the tools for OpenAPI: make openapi-tools"]
fn other_programs_read_channels_types_and_where_a_picture_comes_from() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("all.exr");
    let render = ["render", "demo:vases", "--size", "64x36", "--samples", "4", "--aov", "all", "-q", "-o"];
    output_of(Command::new(program()).args(render).arg(&file));
    let floats = ["R", "G", "B", "A", "key.A", "Z", "P.X", "P.Y", "P.Z", "key.t", "key.v", "key.w"];
    let halves = ["N.X", "N.Y", "N.Z", "key.visibility", "key.direction.X", "key.direction.Y", "key.direction.Z"];
    let of =
        |names: &[&str], kind: &str| names.iter().map(|name| ((*name).to_owned(), json!(kind))).collect::<Vec<_>>();
    let channels: serde_json::Map<_, _> = [of(&floats, "float"), of(&halves, "half")].concat().into_iter().collect();
    // The demo's camera, as `bendylights probe demo:vases` reports it.
    let scene = assets::demo("vases").expect("the demo");
    let camera = &scene.contents.cameras[0];
    let camera_from_world: DMat4 =
        DMat4::from_rotation_translation(DQuat::normalize(camera.rotation), camera.translation).inverse();
    let matrix: Vec<f64> = camera_from_world.to_cols_array().to_vec();
    assert!(camera.translation != DVec3::ZERO);
    let attributes = json!({
        "bendylights.scene": "demo:vases", "bendylights.camera": camera.name, "bendylights.samples": 4,
        "bendylights.fill": 1.0,
    });
    let expected = json!({"size": [64, 36], "channels": channels, "attributes": attributes, "matrix": matrix});
    let found = reads(&file, &expected);
    assert!(found.status.success(), "{}", String::from_utf8_lossy(&found.stderr));
    // Planted faults: another type, another name, another matrix.
    for (pointer, value) in
        [("/channels/Z", json!("half")), ("/attributes/bendylights.camera", json!("other")), ("/matrix/12", json!(7.0))]
    {
        let mut wrong = expected.clone();
        *wrong.pointer_mut(pointer).expect(pointer) = value;
        let found = reads(&file, &wrong);
        assert_eq!(found.status.code(), Some(1), "{pointer}");
        assert!(String::from_utf8_lossy(&found.stderr).contains("finds"), "{pointer}");
    }
}

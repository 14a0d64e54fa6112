//! Tests of `bendylights probe`.

use serde_json::json;

use crate::program::{Folder, SPOT, TRIANGLE, json_for, json_of, printed, refused, run};

/// Pixel in the demo's own picture: the shadow of the blue vase's neck on the table.
const SHADOW: [&str; 2] = ["430.5", "265.5"];

/// A probe and `eval` at the probed position agree.
///
/// Rules: PROBE-1, PROBE-2, PROBE-4
#[test]
fn a_probe_says_what_eval_says_of_the_point() {
    let [x, y] = SHADOW;
    let probed = json_of(&["probe", "demo:vases", "--size", "640x360", x, y]);
    let light = &probed["lights"][0];
    assert_eq!((&light["state"], &light["shadowedBy"]["node"]), (&json!("shadowed"), &json!("blue vase")));
    let folder = Folder::new();
    let asked = json!([{"light": 0, "kind": "hotspot", "size": [640, 360], "from": [430.5, 265.5], "to": [1e9, 0]}]);
    let dragged = json_for(&["drag", "demo:vases", "-"], &asked.to_string());
    assert_eq!(dragged[0]["fromWorld"], probed["seen"]["position"], "a drag sees the same");
    let file = folder.file("light.json", dragged[0]["light"].to_string());
    let points = json!([probed["seen"]["position"]]).to_string();
    let evaluated = json_for(&["eval", &file, "--scene", "demo:vases", "--precision", "0"], &points);
    for field in ["t", "v", "w", "radius", "direction"] {
        assert_eq!(light["place"][field], evaluated[0][field], "{field}");
    }
    assert_eq!(evaluated[0]["occluder"], light["shadowedBy"]["node"]);
    let path = light["path"].as_array().expect("points");
    assert!(path.len() > 10, "a bent way has many points: {}", path.len());
}

/// Rules: PROBE-1, PROBE-2
#[test]
fn a_table_has_a_line_a_light() {
    let [x, y] = SHADOW;
    let text = printed(&["probe", "demo:vases", "--size", "640x360", x, y, "--table"]);
    let lines: Vec<&str> = text.lines().collect();
    assert!(lines.len() == 3 && lines[0].starts_with("table, of table at [0.8609, "), "{text}");
    assert!(
        lines[2].starts_with("key ") && lines[2].contains(" shadowed ") && lines[2].contains("blue vase at ["),
        "{text}"
    );

    let folder = Folder::new();
    let (scene, light) = (folder.file("scene.gltf", TRIANGLE), folder.file("light.json", SPOT));
    let at = |x: &str, y: &str| {
        printed(&["probe", &scene, "--lights", &light, "--camera", "front", "--size", "64x64", x, y, "--table"])
    };
    assert_eq!(at("1", "1"), "nothing is seen there\n");
    assert!(at("32", "36").contains("outside"), "{}", at("32", "36"));
}

/// Rules: PROBE-1
#[test]
fn a_pixel_outside_the_picture_is_refused() {
    for (at, says) in [
        (["-1", "5"], "(-1, 5) is not in a picture of 640x360 pixels"),
        (["640", "5"], "x goes from 0 to less than 640"),
        (["NaN", "5"], "(NaN, 5)"),
        (["5", "inf"], "(5, inf)"),
    ] {
        let done = refused(&["probe", "demo:vases", "--size", "640x360", at[0], at[1]], "", &[says]);
        assert_eq!(done.stdout, "", "{at:?}");
    }
    for size in ["0x5", "8193x5", "640"] {
        let done = run(&["probe", "demo:vases", "--size", size, "1", "1"]);
        assert!(done.code == 2 && done.stderr.contains("8192"), "{}", done.stderr);
    }
    let done = run(&["probe", "demo:vases", "--size", "64x36", "--camera", "attic", "1", "1"]);
    assert!(done.code == 2 && done.stderr.contains("no camera `attic`: choose one of"), "{}", done.stderr);
}

//! Tests of bad input: exit code 2, one sentence on standard error that names the file, nothing on standard
//! output, and no whole or partial picture left behind.

use crate::program::{self, BENDY, Folder, SPOT, TRIANGLE, run};

/// Runs a command that must be refused without an answer, with a sentence that contains all of `must_say`.
fn refused(args: &[&str], input: &str, must_say: &[&str]) {
    assert_eq!(program::refused(args, input, must_say).stdout, "", "{args:?}");
}

/// Folder with a scene and a light.
struct LitScene {
    folder: Folder,
    scene: String,
    light: String,
}

impl LitScene {
    fn new() -> Self {
        let folder = Folder::new();
        Self { scene: folder.file("scene.gltf", TRIANGLE), light: folder.file("light.json", BENDY), folder }
    }

    /// Renders with more options, which must be refused with a sentence that contains all of `must_say`.
    fn refuses(&self, more: &[&str], must_say: &[&str]) {
        let picture = self.folder.path("out.png");
        let render = ["render", &self.scene, "--lights", &self.light, "-o", &picture];
        refused(&[&render[..], more].concat(), "", must_say);
        assert_eq!(self.folder.names(), ["light.json", "scene.gltf"]);
    }
}

/// Light files with a fault, each with a part of the expected message.
const BAD_LIGHTS: &[(&str, &str)] = &[
    ("", "ends where a value should begin"),
    ("{\"type\": \"bendy\",", "line 1, character 17"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1]], "radii": [1,1]}"#, "at least 3 control points"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1],[0,0,-2]], "radii": [1,-1,1]}"#, "-1"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,NaN],[0,0,-2]], "radii": [1,1,1]}"#, "NaN"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,1e999],[0,0,-2]], "radii": [1,1,1]}"#, "out of range"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1],[1,0,-1]], "radii": [5,5,5]}"#, "folds"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,0],[0,0,0]], "radii": [1,1,1]}"#, "one place"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1],[0,0,-2]], "radii": [1,1]}"#, "`radii` has 2 entries"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1],[0,0,-2]], "radii": [1,1,1], "gobo": 1}"#, "field `gobo`"),
    (r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1],[0,0,"-2"]], "radii": [1,1,1]}"#, "points[2][2]: "),
    (r#"{"type": "laser"}"#, "`laser`"),
    (r#"{"type": "spot", "range": -1}"#, "range"),
    ("42", "a light"),
];

#[test]
fn a_bad_light_is_refused_by_every_command_that_reads_it() {
    let folder = Folder::new();
    let scene = folder.file("scene.gltf", TRIANGLE);
    let picture = folder.path("out.png");
    for (content, must_say) in BAD_LIGHTS {
        let light = folder.file("light.json", content);
        refused(&["eval", &light], "[[0,0,0]]", &[&light, must_say]);
        refused(&["bend", &light, "--segments", "2"], "", &[&light, must_say]);
        refused(&["render", &scene, "--lights", &light, "-o", &picture], "", &[&light, must_say]);
    }
    assert_eq!(folder.names(), ["light.json", "scene.gltf"]);
}

#[test]
fn a_missing_or_unreadable_file_is_named() {
    let folder = Folder::new();
    let (nowhere, light, scene) =
        (folder.path("nowhere.json"), folder.file("light.json", BENDY), folder.file("scene.gltf", TRIANGLE));
    let latin1 = folder.file("latin1.json", b"{\"type\": \"bendy\", \"name\": \"\xe9\"}");
    let picture = folder.path("out.png");
    refused(&["eval", &nowhere], "[]", &[&nowhere, "check the name"]);
    refused(&["eval", &light, &nowhere], "", &[&nowhere, "check the name"]);
    refused(&["eval", &latin1], "[]", &[&latin1, "UTF-8"]);
    refused(&["eval", &folder.path("")], "[]", &[&folder.path("")]);
    refused(&["bend", &nowhere, "--segments", "1"], "", &[&nowhere]);
    refused(&["render", &folder.path("nowhere.glb"), "-o", &picture], "", &["nowhere.glb"]);
    refused(&["render", &scene, "--lights", &nowhere, "-o", &picture], "", &[&nowhere]);
    assert!(!folder.names().contains(&"out.png".into()));
}

#[test]
fn bad_points_are_refused() {
    let folder = Folder::new();
    let light = folder.file("light.json", BENDY);
    for (content, must_say) in [
        ("", "ends where a value should begin"),
        ("[[0,0]]", "[0]: has 2 values, where an array of 3 should be"),
        ("[[0,0,NaN]]", "NaN"),
        ("{\"x\": 1}", "is an object, where an array should be"),
        ("[[0,0,0]] [", "something follows"),
    ] {
        let points = folder.file("points.json", content);
        refused(&["eval", &light, &points], "", &[&points, must_say]);
        refused(&["eval", &light, "-"], content, &["standard input", must_say]);
    }
}

#[test]
fn a_light_of_the_wrong_type_or_number_is_refused_with_the_way_out() {
    let folder = Folder::new();
    let (bendy, spot) = (folder.file("bendy.json", BENDY), folder.file("spot.json", SPOT));
    let (none, two) = (folder.file("none.json", "[]"), folder.file("two.json", format!("[{SPOT}, {SPOT}]")));
    refused(&["eval", &spot], "[]", &[&spot, "bendylights bend"]);
    refused(&["bend", &bendy, "--segments", "2"], "", &[&bendy, "`spot`, `omni` or `directional`"]);
    refused(&["bend", "--scene", "demo:vases"], "", &["demo:vases", "no straight light"]);
    for its_own in [["--toward", "-1,0,2"], ["--cone-angle", "20"]] {
        refused(&[&["bend", &spot], &its_own[..]].concat(), "", &[&spot, its_own[0]]);
    }
    let sun = folder.file("sun.json", r#"{"type": "directional"}"#);
    for angle in ["90", "-1", "NaN"] {
        refused(&["bend", &sun, "--cone-angle", angle], "", &[&sun, "coneAngle"]);
        refused(&["bend", &sun, "--cone-angle", angle, "--scene", "demo:vases"], "", &[&sun, "coneAngle"]);
    }
    refused(&["eval", &none], "[]", &[&none, "0 lights"]);
    refused(&["bend", &two, "--segments", "2"], "", &[&two, "2 lights"]);
}

#[test]
fn a_bad_scene_leaves_no_picture() {
    let folder = Folder::new();
    let picture = folder.path("out.png");
    let truncated = folder.file("truncated.glb", &b"glTF\x02\x00\x00\x00\x00\x10\x00\x00"[..]);
    let text = folder.file("text.gltf", "{ not json");
    refused(&["render", &truncated, "-o", &picture], "", &[&truncated]);
    refused(&["render", &text, "-o", &picture], "", &[&text]);
    refused(&["render", &folder.path(""), "-o", &picture], "", &[]);
    refused(&["render", "demo:nothing", "-o", &picture], "", &["`nothing`"]);
    assert_eq!(folder.names(), ["text.gltf", "truncated.glb"]);
}

#[test]
fn a_name_that_is_not_there_is_refused_with_those_that_are() {
    let lit = LitScene::new();
    lit.refuses(&["--camera", "side"], &[&lit.scene, "`side`", "`front`"]);
    lit.refuses(&["--camera", "1"], &[&lit.scene, "`1`", "`front`"]);
    lit.refuses(&["--aov", "t", "--light", "rim"], &[&lit.light, "`rim`", "`key`"]);
}

#[test]
fn a_picture_that_cannot_be_written_is_refused_before_any_work() {
    let folder = Folder::new();
    let scene = folder.file("scene.gltf", TRIANGLE);
    for (picture, must_say) in [
        (folder.path("out.jpg"), ".png nor .exr"),
        (folder.path("out"), ".png nor .exr"),
        (folder.path("missing/out.png"), "check the folder"),
        (folder.path("scene.gltf/out.png"), "check the folder"),
    ] {
        refused(&["render", &scene, "-o", &picture], "", &[&picture, must_say]);
    }
    assert_eq!(folder.names(), ["scene.gltf"]);
}

#[test]
fn shadow_maps_that_cannot_be_are_refused() {
    let lit = LitScene::new();
    for (more, must_say) in [
        (["--shadow-resolution", "8"], "16 texels"),
        (["--shadow-resolution", "1000000"], "make it smaller"),
        (["--shadow-mesh-error", "-0.1"], "world units"),
        (["--shadow-mesh-error", "NaN"], "world units"),
        (["--shadow-mesh-error", "inf"], "world units"),
    ] {
        lit.refuses(&more, &[must_say]);
    }
    for option in ["--shadow-resolution", "--shadow-mesh-error"] {
        lit.refuses(&["--backend", "reference", option, "64"], &[option, "no shadow maps"]);
    }
}

#[test]
fn bad_usage_exits_with_2_and_says_what_is_allowed() {
    let render = |more: &[&'static str]| [&["render", "demo:vases", "-o", "out.png"][..], more].concat();
    for (args, must_say) in [
        (vec![], "Usage"),
        (vec!["paint"], "paint"),
        (vec!["render", "demo:vases"], "-o"),
        (render(&["--size", "0x10"]), "1 to 8192"),
        (render(&["--size", "9000x10"]), "1 to 8192"),
        (render(&["--size", "640"]), "WIDTHxHEIGHT"),
        (render(&["--samples", "0"]), "whole number from 1 to 4096"),
        (render(&["--samples", "1e3"]), "whole number from 1 to 4096"),
        (vec!["bend", "light.json", "--segments", "0"], "whole number from 1 to 256"),
        (vec!["bend", "light.json", "--segments", "2.5"], "whole number from 1 to 256"),
        (vec!["replay", "log.jsonl", "--to", "-1"], "-1"),
        (vec!["serve", "--listen", "localhost"], "HOST:PORT"),
        (render(&["--aov", "albedo"]), "visibility"),
        (render(&["--fill", "-1"]), "from 0 to 1000000"),
        (render(&["--fill", "NaN"]), "from 0 to 1000000"),
        (render(&["--exposure", "-33"]), "from -32 to 32"),
        (render(&["--exposure", "bright"]), "from -32 to 32"),
        (render(&["--fill", "none"]), "from 0 to 1000000"),
        (vec!["eval", "light.json", "--on", "f16"], "f64, f32, gpu"),
        (vec!["bend", "light.json", "--segments", "-1"], "-1"),
        (vec!["bend", "light.json", "--toward", "1,2"], "three numbers"),
        (vec!["bend", "light.json", "--toward", "1,2,inf"], "three numbers"),
    ] {
        let done = run(&args);
        assert_eq!((done.code, done.stdout.as_str()), (2, ""), "{args:?}");
        assert!(done.stderr.contains(must_say), "{args:?}: {}", done.stderr);
    }
}

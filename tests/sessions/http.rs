//! Sessions over HTTP alone.

use bench::ServerProcess;
use protocol::{
    Asset, EditResults, ErrorBody, ErrorCode, Outcome, Picked, Record, SessionList, SessionState, Vec3, parse_body,
};
use serde_json::json;

use crate::program::program;
use crate::sessions::support::{DEMO, Server, ok, pixels};

fn code(response: &bench::Response) -> &'static str {
    parse_body::<ErrorBody>(&response.text()).expect("an error").error.code.name()
}

fn session(response: &bench::Response) -> SessionState {
    parse_body(&response.text()).expect("a session")
}

/// Rules: HTTP-4, HTTP-5, DOC-1, DOC-5, CMD-6
#[test]
fn sessions_are_made_and_listed() {
    let server = Server::start();
    let made = server.post("/sessions", &json!({"name": "shot-010", "scene": "demo:vases"}));
    assert_eq!(made.status, 201, "{}", made.text());
    let made = session(&made);
    assert_eq!((made.name.as_str(), made.seq), ("shot-010", 1));
    let ids: Vec<u64> = made.document.lights.iter().map(|light| light.id).collect();
    assert!(!ids.is_empty() && ids.is_sorted() && !made.document.cameras.is_empty());

    // A demo's name and its asset's name are the same scene.
    let asset = made.document.scene.expect("a scene").asset;
    let same = server.post("/sessions", &json!({"name": "shot-020", "scene": asset}));
    assert_eq!(session(&same).hash, made.hash);

    let taken = server.post("/sessions", &json!({"name": "main"}));
    assert_eq!((taken.status, code(&taken)), (409, "exists"));
    for name in ["", "-x", "a/b", "../x", &"x".repeat(65)] {
        let refused = server.post("/sessions", &json!({"name": name}));
        assert_eq!(refused.status, 400, "{name}: {}", refused.text());
    }
    let nowhere = server.post("/sessions", &json!({"name": "no", "scene": format!("sha256:{}", "0".repeat(64))}));
    assert_eq!(code(&nowhere), "unknownAsset");

    let list: SessionList = parse_body(&server.get("/sessions").text()).expect("a list");
    let names: Vec<&str> = list.sessions.iter().map(|entry| entry.name.as_str()).collect();
    assert_eq!(names, ["main", "shot-010", "shot-020"]);
    assert_eq!(code(&server.get("/sessions/no")), "notFound");
}

/// Rules: HTTP-6, HTTP-7, CMD-1, CMD-3, CMD-4, CMD-5, UNDO-5
#[test]
fn programs_edit_undo_and_read_the_log() {
    let server = Server::start();
    let light = server.connect("setup").light();
    let set = |point: usize, parameter: serde_json::Value| json!({"command": {"type": "setPoint", "light": light, "point": point, "parameter": parameter}});
    let edits = json!({"actor": {"id": "ci", "name": "CI"}, "edits": [
        set(2, json!({"radius": 1.5})),
        set(2, json!({"radius": 1.5})),
        set(99, json!({"radius": 1.5})),
        set(0, json!({"position": [1, 1, 1]})),
        set(2, json!({"radius": 1e9})),
        {"undo": "mine"}, {"undo": "mine"}, {"undo": "mine"}, {"redo": "mine"},
    ]});
    let answer = ok(server.post("/sessions/main/edits", &edits)).text();
    let answer: EditResults = parse_body(&answer).expect("results");
    let code = |outcome: &Outcome| outcome.code().map_or("", ErrorCode::name);
    let codes: Vec<_> = answer.results.iter().map(|result| code(&result.outcome)).collect();
    let expected = ["", "", "notFound", "source", "invalidLight", "", "nothingToUndo", "nothingToUndo", ""];
    assert_eq!(codes, expected);
    assert!(!answer.results.iter().any(|result| matches!(result.outcome, Outcome::Unknown(_))));
    assert_eq!((answer.seq, answer.hash), server.state());

    let log = server.get("/sessions/main/log?from=2&limit=2").text();
    let records: Vec<Record> = log.lines().map(|line| parse_body(line).expect("a record")).collect();
    assert_eq!(records.iter().map(|record| record.seq).collect::<Vec<_>>(), [2, 3]);
    assert_eq!((records[0].changes.len(), records[1].changes.len()), (1, 0), "the second changed nothing");
    assert_eq!(records[0].actor.id, "ci");
}

/// Rules: HTTP-8
#[test]
fn pictures_come_in_every_form() {
    let server = Server::start();
    let picture = |query: &str| server.get(&format!("/sessions/main/render?size=64x36&{query}"));
    let beauty = ok(picture(""));
    assert_eq!(pixels(&beauty.body).len(), 64 * 36 * 3);
    for aov in ["depth", "normal", "position", "t", "vw", "direction", "visibility"] {
        let shown = picture(&format!("aov={aov}"));
        assert_eq!(shown.status, 200, "{aov}: {}", shown.text());
        assert_ne!(pixels(&shown.body), pixels(&beauty.body), "{aov}");
    }
    let exr = picture("format=exr&aov=t");
    assert_eq!(exr.body[..4], [0x76, 0x2f, 0x31, 0x01], "OpenEXR's magic number");
    // Outside of the light the lights' own radiance is zero; the fill adds a little.
    let black = |picture: &bench::Response| pixels(&picture.body).chunks(3).filter(|pixel| **pixel == [0; 3]).count();
    let [alone, dim] = ["fill=0", "fill=0.5"].map(picture);
    assert!(black(&alone) > 64 * 36 / 4 && black(&beauty) == 0, "{} {}", black(&alone), black(&beauty));
    assert_eq!(pixels(&picture("fill=1").body), pixels(&beauty.body));
    assert_ne!(pixels(&dim.body), pixels(&beauty.body));
    let sum = |picture: &bench::Response| pixels(&picture.body).iter().map(|byte| u64::from(*byte)).sum::<u64>();
    let [darker, brighter] = ["exposure=-1.5", "exposure=1"].map(picture);
    assert!(sum(&darker) < sum(&beauty) && sum(&beauty) < sum(&brighter));
    assert_eq!(pixels(&picture("exposure=0").body), pixels(&beauty.body));
    // Exposure does not affect the values of EXR files.
    assert_eq!(picture("format=exr&exposure=3").body, picture("format=exr").body);
    let wrong = "fill=-1 fill=NaN fill=all exposure=32.1 exposure=NaN size=0x9 aov=shade samples=100000 \
                 aov=t&light=nobody light=key camera=nobody at=99 format=gif x=1";
    for wrong in wrong.split(' ') {
        let refused = picture(wrong);
        assert!((400..500).contains(&refused.status), "{wrong}: {}", refused.status);
        assert!(!code(&refused).is_empty());
    }
}

/// Straight down from two heights the same point is seen, and nothing straight up.
///
/// Rules: HTTP-21
#[test]
fn a_camera_is_told_what_it_looks_at() {
    let server = Server::start();
    let down = std::f64::consts::FRAC_1_SQRT_2;
    let pick = |translation: Vec3, rotation: [f64; 4], projection: serde_json::Value| {
        let camera = json!({"name": "", "translation": translation, "rotation": rotation, "projection": projection});
        let answer = ok(server.post("/sessions/main/pick", &json!({ "camera": camera })));
        parse_body::<Picked>(&answer.text()).expect("a point").point
    };
    let perspective = || json!({"perspective": {"yfov": 0.7, "aspectRatio": 2.4, "znear": 0.01}});
    let orthographic = json!({"orthographic": {"ymag": 1.5, "znear": 0.0, "zfar": 50.0}});
    let turned = [-down, 0.0, 0.0, down];
    let low = pick([0.3, 7.0, 0.2], turned, perspective()).expect("the scene is below");
    let high = [pick([0.3, 12.0, 0.2], turned, perspective()), pick([0.3, 9.0, 0.2], turned, orthographic)];
    for other in high {
        let other = other.expect("the scene is below");
        // Coordinates of at most 20, rounded a few times.
        let apart = other.iter().zip(low).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 20.0 * 16.0 * f64::EPSILON, "{low:?} {other:?}");
    }
    assert!((low[0] - 0.3).abs() < 1e-12 && (low[2] - 0.2).abs() < 1e-12 && low[1] < 6.0, "{low:?}");
    assert_eq!(pick([0.3, 12.0, 0.2], [down, 0.0, 0.0, down], perspective()), None, "the sky");
    let flat = json!({"camera": {"name": "", "translation": [0, 0, 0], "rotation": [0, 0, 0, 1],
        "projection": {"perspective": {"yfov": 0, "znear": 1}}}});
    let refused = server.post("/sessions/main/pick", &flat);
    assert_eq!((refused.status / 100, code(&refused)), (4, "invalidCamera"));
}

/// Rules: HTTP-10, DOC-5
#[test]
fn scenes_are_uploaded_by_their_bytes() {
    let server = Server::start();
    let gltf = json!({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "eye", "camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}]});
    let bytes = gltf.to_string();
    let made = server.address.post("/assets", bytes.as_bytes()).expect("answered");
    assert_eq!(made.status, 201, "{}", made.text());
    let asset: Asset = parse_body(&made.text()).expect("a name");
    assert_eq!(asset.asset, document::AssetHash::of(bytes.as_bytes()).to_string(), "what sha256sum says");
    let session = session(&server.post("/sessions", &json!({"name": "mine", "scene": asset.asset})));
    assert_eq!(session.document.cameras[0].camera.name, "eye");
    let name = session.document.scene.expect("a scene").name;
    assert_eq!(name, format!("scene {}", &asset.asset["sha256:".len()..][..8]), "not all of the hash");
    assert_eq!(name, asset.name);

    let refused = server.address.post("/assets", b"not a scene").expect("answered");
    assert_eq!(refused.status, 400, "{}", refused.text());
}

/// A log that cannot be written, as on a full disk, is lost. Everything else works.
///
/// Rules: HTTP-6
#[cfg(unix)]
#[test]
fn a_server_whose_log_goes_nowhere_serves_on() {
    use std::os::unix::fs::PermissionsExt;

    let folder = tempfile::tempdir().expect("a folder");
    let silent = folder.path().join("silent");
    let script = format!("#!/bin/sh\nexec '{}' \"$@\" 2> /dev/full\n", program().display());
    std::fs::write(&silent, script).expect("written");
    std::fs::set_permissions(&silent, std::fs::Permissions::from_mode(0o755)).expect("set");
    let data = folder.path().join("data");
    let process = ServerProcess::start(&silent, &data, DEMO).expect("started");
    process.wait_until_ready().expect("ready");
    let undo = json!({"edits": [{"undo": "mine"}]}).to_string();
    ok(process.post("/sessions/main/edits", undo.as_bytes()).expect("answered"));
    ok(process.get("/sessions/main").expect("answered"));
}

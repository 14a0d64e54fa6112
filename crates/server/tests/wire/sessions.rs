//! Sessions over HTTP.

use std::fs;
use std::os::unix::fs::PermissionsExt;

use serde_json::{Value, json};

use crate::client::{Client, add_asset, edit, get, make_session, new_session, post, state, upload};
use crate::server::{OwnServer, SHARED};

fn cone_angle(degrees: f64) -> Value {
    json!({"type": "setLight", "light": 1, "parameter": {"coneAngle": degrees}})
}

/// Rules: HTTP-4
#[test]
fn a_session_is_made_once() {
    let session = json!({"name": "Made.once-1_"});
    assert_eq!(make_session(&SHARED, &session)["seq"], 0);
    assert_eq!(post(&SHARED, "/sessions", &session).refusal(), (409, "exists".into()));
    for name in ["", ".hidden", "a b", "a/b", "ä", &"a".repeat(65)] {
        let refused = post(&SHARED, "/sessions", &json!({ "name": name }));
        assert_eq!(refused.refusal(), (400, "badName".into()), "{name}");
    }
    let no_scene = post(&SHARED, "/sessions", r#"{"name": "no-scene", "scene": "demo:nothing"}"#);
    assert_eq!(no_scene.refusal(), (404, "unknownAsset".into()));
    assert_eq!(get(&SHARED, "/sessions/no-scene").status, 404, "a session without its scene is not made");
}

/// Rules: HTTP-5
#[tokio::test]
async fn a_session_is_shown_with_its_document() {
    new_session(&SHARED, "shown");
    let (_client, welcome) = Client::join(&SHARED, "shown", "Ada").await;
    let shown = state(&SHARED, "shown");
    assert_eq!((shown["hash"].as_str(), shown["epoch"].as_str()), (Some(&*welcome.hash), Some(&*welcome.epoch)));
    assert_eq!(shown["document"]["scene"]["name"], "demo:vases");
    assert_eq!(shown["document"]["lights"][0]["light"]["name"], "key");
}

/// Rules: HTTP-6, HTTP-7, REC-4
#[test]
fn edits_are_answered_one_by_one_and_logged() {
    new_session(&SHARED, "edited");
    let body = json!({"actor": {"id": "ada", "name": "Ada"}, "edits": [
        {"opId": "narrow", "command": cone_angle(20.0)},
        {"command": {"type": "removeLight", "light": 99}},
        {"opId": "wide", "command": cone_angle(25.0)},
        {"undo": "mine"},
        {"command": {"type": "loadScene", "scene": "demo:nothing"}},
        {"opId": "narrow", "command": cone_angle(20.0)},
    ]});
    let answer = edit(&SHARED, "edited", &body);
    let results = answer["results"].as_array().unwrap();
    let statuses: Vec<_> = results.iter().map(|result| result["status"].as_str().unwrap()).collect();
    assert_eq!(statuses, ["committed", "rejected", "committed", "committed", "rejected", "committed"]);
    let seqs: Vec<_> = results.iter().map(|result| result["seq"].as_u64()).collect();
    assert_eq!(seqs, [Some(2), None, Some(3), Some(4), None, Some(2)], "the last was carried out before");
    assert_eq!((results[1]["code"].as_str(), results[4]["code"].as_str()), (Some("notFound"), Some("unknownAsset")));
    assert_eq!(answer["hash"], state(&SHARED, "edited")["hash"]);

    let seqs = |query: &str| -> Vec<u64> {
        let log = get(&SHARED, &format!("/sessions/edited/log{query}"));
        let record = |line: &str| serde_json::from_str::<Value>(line).unwrap()["seq"].as_u64().unwrap();
        log.text().lines().map(record).collect()
    };
    assert_eq!(seqs(""), [1, 2, 3, 4]);
    assert_eq!(seqs("?from=2&limit=2"), [2, 3]);
    assert_eq!(seqs("?from=5"), [0; 0]);
}

/// Rules: HTTP-15
#[tokio::test]
async fn only_the_owner_can_read_the_data_folder() {
    let own = OwnServer::start().await;
    let mut folders = vec![own.folder.path().to_owned()];
    let mut seen = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let (path, metadata) = entry.map(|entry| (entry.path(), entry.metadata().unwrap())).unwrap();
            assert_eq!(metadata.permissions().mode() & 0o077, 0, "{}", path.display());
            seen.push(path.file_name().unwrap().to_owned());
            if metadata.is_dir() {
                folders.push(path);
            }
        }
    }
    for name in ["token", "lock", "assets", "bendylights.sqlite", "bendylights.sqlite-wal"] {
        assert!(seen.iter().any(|found| found == name), "{name} is not among {seen:?}");
    }
}

/// Rules: HTTP-10, CMD-6
#[test]
fn a_scene_is_sent_and_then_loaded_by_its_name() {
    let scene = br#"{"asset": {"version": "2.0"}, "nodes": [{"name": "nothing"}]}"#;
    let asset = add_asset(&SHARED, "", scene)["asset"].as_str().unwrap().to_owned();
    assert_eq!(add_asset(&SHARED, "", scene)["asset"], asset.as_str(), "the same bytes have the same name");
    assert_eq!(upload(&SHARED, "", b"not a scene").refusal(), (400, "badScene".into()));

    new_session(&SHARED, "loaded");
    let load = |scene: &str| json!({"edits": [{"command": {"type": "loadScene", "scene": scene}}]});
    assert_eq!(edit(&SHARED, "loaded", &load(&asset))["results"][0]["seq"], 2);
    assert_eq!(state(&SHARED, "loaded")["document"]["lights"], json!([]));
    let unknown = edit(&SHARED, "loaded", &load(&format!("sha256:{}", "0".repeat(64))));
    assert_eq!(unknown["results"][0]["code"], "unknownAsset");
    let undone = edit(&SHARED, "loaded", &json!({"edits": [{"undo": "mine"}]}));
    assert_eq!(undone["results"][0]["skipped"], Value::Null, "the scene before is found again");
    assert_eq!(state(&SHARED, "loaded")["document"]["scene"]["name"], "demo:vases");
}

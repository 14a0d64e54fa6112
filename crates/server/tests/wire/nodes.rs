//! Nodes of a session's scene, and links that name them.

use serde_json::{Value, json};

use crate::client::{add_asset, get, make_session, new_session, results_of, set, state};
use crate::server::SHARED;

/// Returns a triangle in three nodes, two of one name under another node, and a node without geometry.
fn scene() -> Vec<u8> {
    let zeros = "AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA";
    let file = json!({"asset": {"version": "2.0", "generator": "nodes"}, "scenes": [{"nodes": [0, 4, 5]}],
        "nodes": [{"name": "room", "children": [1, 2, 3]}, {"name": "a/b", "mesh": 0}, {"name": "a/b", "mesh": 0},
            {"name": "empty"}, {"mesh": 0}, {"name": "lamp"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [0, 0, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}],
        "buffers": [{"byteLength": 36, "uri": format!("data:application/octet-stream;base64,{zeros}")}]});
    file.to_string().into_bytes()
}

/// Rules: HTTP-20, LINK-1
#[test]
fn a_session_tells_the_nodes_of_its_scene() {
    let door = &SHARED;
    make_session(door, &json!({"name": "nodes", "scene": add_asset(door, "", &scene())["asset"]}));
    let paths = json!(["room", "room/a~1b", "room/a~1b#2", "node 4"]);
    assert_eq!(get(door, "/sessions/nodes/nodes").json(), json!({"paths": paths, "leftOut": 0}));
    make_session(door, &json!({"name": "no-nodes"}));
    assert_eq!(get(door, "/sessions/no-nodes/nodes").json(), json!({"paths": [], "leftOut": 0}));
    assert_eq!(get(door, "/sessions/nobody/nodes").status, 404);
}

/// Links are set, undone and set again like any parameter, whatever the scene has, and refused beyond their limits.
///
/// Rules: LINK-3, LINK-4, UNDO-4, CMD-9
#[test]
fn links_are_edited_as_any_parameter() {
    let (door, session) = (&SHARED, "links");
    new_session(door, session);
    let state = || state(door, session);
    let light = || state()["document"]["lights"][0]["light"].take();
    let before = state()["hash"].clone();
    let edited = |edit: Value| results_of(door, session, &json!([edit])).remove(0);
    let set = |target: &str, value: Value| edited(json!({"command": set(target, value)}));
    let links = json!({"include": ["blue vase", "attic/chair"], "exclude": ["blue vase"]});
    assert_eq!(set("/lights/1/lightLink", links)["status"], "committed");
    let sorted = json!({"include": ["attic/chair", "blue vase"], "exclude": ["blue vase"]});
    assert_eq!(light()["lightLink"], sorted);
    let linked = state()["hash"].clone();
    assert_eq!(edited(json!({"undo": "mine"}))["status"], "committed");
    assert_eq!((&light()["lightLink"], &state()["hash"]), (&Value::Null, &before));
    assert_eq!(edited(json!({"redo": "mine"}))["status"], "committed");
    assert_eq!(state()["hash"], linked);
    assert_eq!(set("/lights/1/lightLink", json!({}))["status"], "committed");
    assert_eq!(state()["hash"], before, "empty lists are none");

    let many: Vec<String> = (0..1025).map(|node| node.to_string()).collect();
    let refused = set("/lights/1/shadowLink", json!({"exclude": many}));
    assert_eq!(refused["code"], "invalidLight");
    let message = refused["message"].as_str().unwrap_or_default();
    assert!(message.contains("`shadowLink`") && message.contains("1024"), "{message}");
}

//! Scenes over HTTP: their names, and their parts that are not drawn.

use std::fs;

use document::AssetHash;
use protocol::{ClientMessage, Command, Scope, ServerMessage};
use serde_json::{Value, json};

use crate::client::{Client, HttpAnswer, add_asset, edit, get, make_session, post, results_of, state, upload};
use crate::server::{OwnServer, SHARED, ServerDoor};

/// Returns a scene's file that no other test sends, since it contains `mark`.
fn file(mark: &str, own_name: Option<&str>) -> Vec<u8> {
    let scene = own_name.map_or(json!({"nodes": [0]}), |name| json!({"name": name, "nodes": [0]}));
    let file = json!({"asset": {"version": "2.0", "generator": mark}, "scenes": [scene], "nodes": [{"name": "n"}]});
    file.to_string().into_bytes()
}

/// Returns a scene's file with a light of negative intensity and an animation, which is not played.
fn file_with_notes(mark: &str) -> Vec<u8> {
    let light = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "name": "bulb", "intensity": -1}]}});
    let file = json!({"asset": {"version": "2.0", "generator": mark}, "scenes": [{"nodes": [0]}],
        "nodes": [{"extensions": {"KHR_lights_punctual": {"light": 0}}}], "animations": [{"channels": [], "samplers": []}],
        "extensionsUsed": ["KHR_lights_punctual"], "extensions": light});
    file.to_string().into_bytes()
}

/// Makes a session that loads `scene`. Returns the name that its document has for the scene, and the session's notes.
fn loaded(door: &ServerDoor, session: &str, scene: &Value) -> (Value, Value) {
    let made = make_session(door, &json!({"name": session, "scene": scene}));
    let shown = state(door, session);
    assert_eq!((&shown["document"]["scene"], &shown["notes"]), (&made["document"]["scene"], &made["notes"]));
    (shown["document"]["scene"]["name"].clone(), shown["notes"].clone())
}

/// Rules: HTTP-10, CMD-7
#[test]
fn a_scene_is_called_what_its_sender_or_its_file_calls_it() {
    // Name of an unnamed scene.
    let short = |file: &[u8]| format!("scene {}", &AssetHash::of(file).hex()[..8]);
    let (unnamed, unfit, exported) =
        (file("unnamed", None), file("unfit", Some(" \n ")), file("exported", Some("Scene")));
    let cases = [
        ("", file("own", Some("Küche")), "Küche".to_owned()),
        ("?name=K%C3%BCche%20%E2%98%95%20%2B1", file("given", Some("Attic")), "Küche ☕ +1".to_owned()),
        ("?name=..%2F..%2F..%2Fetc%2Fpasswd", file("path", None), "../../../etc/passwd".to_owned()),
        ("?name=..", file("dots", None), "..".to_owned()),
        ("", unnamed.clone(), short(&unnamed)),
        ("", unfit.clone(), short(&unfit)),
        ("", exported.clone(), short(&exported)),
    ];
    for (number, (query, file, name)) in cases.into_iter().enumerate() {
        let sent = add_asset(&SHARED, query, &file);
        assert_eq!(sent["name"], name, "{query}");
        assert_eq!(loaded(&SHARED, &format!("called-{number}"), &sent["asset"]).0, name, "{query}");
    }
    // A demo has its name, whether it is requested by name or by hash.
    let demo = AssetHash::of(&assets::demo_bytes("vases").unwrap()).to_string();
    assert_eq!(loaded(&SHARED, "called-demo", &json!("demo:vases")).0, "demo:vases");
    assert_eq!(loaded(&SHARED, "called-by-hash", &json!(demo)).0, "demo:vases");
}

/// Rules: HTTP-10, CMD-7
#[test]
fn a_scene_that_is_sent_again_takes_the_later_name() {
    let file = file("twice", Some("Scene"));
    let asset = add_asset(&SHARED, "?name=first", &file)["asset"].clone();
    assert_eq!(loaded(&SHARED, "twice-1", &asset).0, "first");
    assert_eq!(add_asset(&SHARED, "?name=second", &file)["name"], "second");
    assert_eq!(add_asset(&SHARED, "", &file)["name"], "second", "without a name it keeps the one it has");
    assert_eq!(loaded(&SHARED, "twice-2", &asset).0, "second");
    let before = state(&SHARED, "twice-1");
    assert_eq!(before["document"]["scene"]["name"], "first", "documents keep the name they loaded it under");
    let edits = json!({"edits": [{"command": {"type": "loadScene", "scene": asset, "name": "mine"}}]});
    edit(&SHARED, "twice-1", &edits);
    let named = state(&SHARED, "twice-1");
    assert_eq!(named["document"]["scene"]["name"], "mine", "a command's own name comes first");
}

/// Rules: HTTP-10
#[test]
fn an_invalid_scene_name_is_refused_with_a_sentence() {
    let long = format!("?name={}", "x".repeat(257));
    for query in ["?name=", "?name=%20room", "?name=room%0A", "?name=%00", "?name=%C2%85", "?name=%ff", &long] {
        let refused = upload(&SHARED, query, &file("refused", None));
        assert_eq!(refused.refusal(), (400, "badName".into()), "{query}");
        assert!(refused.text().contains("256"), "{}", refused.text());
    }
    assert_eq!(upload(&SHARED, "?nmae=room", &file("refused", None)).refusal(), (400, "badMessage".into()));
    let asset = AssetHash::of(&file("refused", None)).to_string();
    let unknown = post(&SHARED, "/sessions", &json!({"name": "of-refused", "scene": asset}));
    assert_eq!(unknown.refusal(), (404, "unknownAsset".into()), "nothing of it is kept");
}

/// Rules: HTTP-10
#[tokio::test(flavor = "multi_thread")]
async fn names_and_notes_survive_restarts_and_old_folders_have_some() {
    let own = OwnServer::start().await;
    let (named, noted) = (file("kept", Some("Scene")), file_with_notes("kept"));
    let sent = add_asset(&own.door, "?name=Kitchen", &named)["asset"].clone();
    loaded(&own.door, "before", &sent);
    let with_notes = add_asset(&own.door, "", &noted)["asset"].clone();
    let (_, notes) = loaded(&own.door, "noted", &with_notes);
    // An asset of a version without names.
    let old = file("old", Some("Attic"));
    fs::write(own.folder.path().join("assets").join(AssetHash::of(&old).hex()), &old).unwrap();

    let own = OwnServer::start_in(own.stopped().await).await;
    assert_eq!(loaded(&own.door, "after", &sent).0, "Kitchen");
    assert_eq!(state(&own.door, "before")["document"]["scene"]["name"], "Kitchen");
    assert_eq!(state(&own.door, "noted")["notes"], notes);
    assert!(!notes.as_array().unwrap().is_empty());
    assert_eq!(loaded(&own.door, "old", &json!(AssetHash::of(&old).to_string())).0, "Attic");
}

/// Rules: HTTP-10, HTTP-5, SOCK-11, FRAME-9
#[tokio::test]
async fn notes_on_parts_that_are_not_drawn_come_everywhere() {
    let sent = add_asset(&SHARED, "", &file_with_notes("told"));
    let expected = [
        "animations are not played, everything is at rest: 1 of them",
        "colors and intensities below 0 are taken as 0: bulb",
    ];
    assert_eq!(sent["notes"], json!(expected));
    assert_eq!(add_asset(&SHARED, "", &file("without notes", None))["notes"], json!([]));

    let (mut ada, welcome) = Client::join(&SHARED, "main", "Ada").await;
    assert_eq!(welcome.notes, [""; 0], "the demo is drawn whole");
    let scene = sent["asset"].as_str().unwrap().to_owned();
    let command = Command::LoadScene { scene, name: None };
    ada.say_edit("load", welcome.seq, command).await;
    let logged = |message| match message {
        ServerMessage::Log { bounds, notes, record, .. } => Some((bounds.is_some(), notes, record.seq)),
        _ => None,
    };
    let (has_bounds, notes, seq) = ada.until(logged).await;
    assert_eq!((has_bounds, notes), (true, Some(expected.map(String::from).to_vec())));
    let (_ben, welcome) = Client::join(&SHARED, "main", "Ben").await;
    assert_eq!(welcome.notes, expected);

    let picture = |query: &str| get(&SHARED, &format!("/sessions/main/render?size=16x9{query}"));
    let headers = |answer: &HttpAnswer| {
        let values = answer.headers.get_all("x-bendylights-note").iter();
        values.map(|value| value.to_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(headers(&picture("")), expected);
    assert_eq!(headers(&picture(&format!("&at={}", seq - 1))), [""; 0], "as it was then");
    ada.say(&ClientMessage::Undo { op_id: "back".into(), scope: Scope::Session }).await;
    assert_eq!(ada.until(logged).await.1, Some(Vec::new()), "the demo again");
    assert_eq!(headers(&picture("")), [""; 0]);
    assert_eq!(headers(&picture(&format!("&at={seq}"))), expected);
}

/// The light that is added to a scene without lights is in the record like any other. It can be removed, and undo
/// restores it.
///
/// Rules: CMD-13, SOCK-11
#[test]
fn a_scene_without_lights_comes_with_a_key_that_can_be_removed() {
    let buffer = "data:application/octet-stream;base64,AACAvwAAgL8AAAAAAACAPwAAgL8AAAAAAAAAAAAAgD8AAAAA";
    let file = json!({"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3",
            "min": [-1, -1, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": buffer}]});
    let sent = add_asset(&SHARED, "", file.to_string().as_bytes());
    let says_so = |notes: &Value| notes.to_string().matches("default key").count() == 1;
    assert!(says_so(&sent["notes"]), "{sent}");
    assert!(says_so(&loaded(&SHARED, "keyed", &sent["asset"]).1));
    let lights = || state(&SHARED, "keyed")["document"]["lights"].clone();
    let key = lights()[0].clone();
    assert_eq!((&key["light"]["name"], &key["light"]["type"]), (&json!("default key"), &json!("directional")));
    let log = get(&SHARED, "/sessions/keyed/log");
    let record = log.text();
    assert!(record.contains("default key") && record.contains("directional"), "{record}");
    let edit = |edit: Value| {
        results_of(&SHARED, "keyed", &json!([edit]));
        lights().as_array().map(Vec::len)
    };
    assert_eq!(edit(json!({"command": {"type": "removeLight", "light": key["id"]}})), Some(0));
    assert_eq!(edit(json!({"undo": "mine"})), Some(1));
    assert_eq!(lights()[0], key);
}

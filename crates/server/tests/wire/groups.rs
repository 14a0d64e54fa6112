//! Edits that make one step.

use serde_json::{Value, json};

use crate::client::{HttpAnswer, edit, get, new_session, post_edits, set, spot, state};
use crate::server::SHARED;

fn atomic(session: &str, op_id: &str, commands: &Value) -> HttpAnswer {
    let edits: Vec<Value> =
        commands.as_array().expect("commands").iter().map(|command| json!({"command": command})).collect();
    post_edits(&SHARED, session, &json!({"atomic": true, "opId": op_id, "edits": edits}))
}

/// Returns the one result of edits that make one step.
fn result(answer: &HttpAnswer) -> Value {
    assert_eq!(answer.status, 200, "{}", answer.text());
    let results = answer.json()["results"].clone();
    assert_eq!(results.as_array().map(Vec::len), Some(1), "{results}");
    results[0].clone()
}

/// Rules: CMD-17, CMD-16, HTTP-6, REC-8, REC-4
#[test]
fn edits_are_one_step_where_that_is_asked() {
    new_session(&SHARED, "atomic");
    let before = state(&SHARED, "atomic");
    let key = &before["document"]["lights"][0]["id"];
    let view = before["document"]["cameras"][0]["camera"].clone();
    let drag = |to: [f64; 2]| {
        json!({"type": "dragFeature", "light": key, "kind": "hotspot", "camera": view, "size": [640, 360],
            "from": [320.5, 180.5], "to": to})
    };
    // A name in a command may have been added by an earlier one in the group. Parts that depend on the scene are solved
    // in the document after the earlier commands.
    let commands = json!([
        spot("rim"),
        set("/lights/rim/exposure", 2),
        set("/lights/key/exposure", 0.5),
        drag([340.5, 180.5]),
        {"type": "straightenLight", "light": key},
        {"type": "bendLight", "light": key}
    ]);
    let done = result(&atomic("atomic", "group", &commands));
    assert_eq!(done["status"], "committed", "{done}");
    assert_eq!(done["seq"].as_u64(), before["seq"].as_u64().map(|seq| seq + 1));
    let rim = done["added"]["lights"][0].clone();
    let outcomes = done["outcomes"].as_array().expect("outcomes");
    let landed: Vec<bool> = outcomes.iter().map(|outcome| outcome["status"] == "landed").collect();
    assert_eq!(landed, [false, false, false, true, false, false], "{outcomes:?}");
    let after = state(&SHARED, "atomic");
    let light = |id: &Value| {
        let lights = after["document"]["lights"].as_array().expect("lights").clone();
        lights.into_iter().find(|light| light["id"] == *id).expect("that light")["light"].clone()
    };
    assert_eq!((&light(&rim)["exposure"], &light(key)["type"]), (&json!(2.0), &json!("bendy")));
    assert_eq!(result(&atomic("atomic", "group", &commands)), done, "the same operation again");

    let undo = json!({"edits": [{"undo": "mine"}, {"redo": "mine"}, {"undo": "mine"}]});
    let undone = edit(&SHARED, "atomic", &undo);
    assert_eq!(undone["hash"], before["hash"]);
    assert!(undone["results"].as_array().expect("results").iter().all(|result| result["status"] == "committed"));
    // The record has ids instead of names, and each drag's outcome.
    let log = get(&SHARED, "/sessions/atomic/log?from=2&limit=1").text().to_owned();
    let record: Value = serde_json::from_str(&log).expect("a record");
    assert_eq!((&record["format"], &record["action"]["type"]), (&json!(6), &json!("group")));
    assert_eq!(record["action"]["edits"][1]["command"]["light"], rim);
    assert_eq!(record["action"]["edits"][3]["outcome"], outcomes[3]);
}

/// Deliberate fault that the check must detect: the same edits without `atomic`, of which the valid ones are carried
/// out.
///
/// Rules: CMD-17, HTTP-6
#[test]
fn where_one_edit_is_refused_none_is_done() {
    new_session(&SHARED, "all-or-none");
    let (before, good) = (state(&SHARED, "all-or-none"), set("/lights/key/exposure", 1));
    let refused = [
        (json!([good, set("/lights/key/coneSoftness", 7)]), "invalidLight", "edit 2 of the group: "),
        (json!([set("/lights/nobody/exposure", 1), good]), "notFound", "edit 1 of the group: "),
        (json!([good, good, set("/lights/key/shine", 1)]), "badMessage", "edit 3 of the group: "),
        (json!([good, {"type": "loadScene", "scene": "demo:vases"}]), "badMessage", "request of its own"),
        (json!([good, {"type": "removePoint", "light": 1, "point": 400}]), "notFound", "edit 2 of the group: "),
    ];
    for (number, (commands, code, said)) in refused.iter().enumerate() {
        let result = result(&atomic("all-or-none", &format!("refused {number}"), commands));
        assert_eq!((&result["status"], &result["code"]), (&json!("rejected"), &json!(code)), "{result}");
        assert!(result["message"].as_str().expect("a sentence").contains(said), "{result}");
    }
    let ill = [
        json!({"atomic": true, "edits": [{"undo": "mine"}]}),
        json!({"atomic": true, "edits": [{"opId": "own", "command": good}]}),
        json!({"atomic": true, "edits": [{}]}),
    ];
    for body in ill {
        let answer = post_edits(&SHARED, "all-or-none", &body);
        assert_eq!(result(&answer)["code"], "badMessage", "{body}");
    }
    let many: Vec<Value> = (0..257).map(|_| good.clone()).collect();
    assert_eq!(atomic("all-or-none", "many", &json!(many)).refusal(), (413, "tooLarge".into()));
    let named = json!({"opId": "one", "edits": [{"command": good}]});
    assert_eq!(post_edits(&SHARED, "all-or-none", &named).refusal(), (400, "badMessage".into()));
    assert_eq!(state(&SHARED, "all-or-none")["hash"], before["hash"]);
    let one_by_one = json!({"edits": [{"command": good}, {"command": set("/lights/key/coneSoftness", 7)}]});
    assert_ne!(edit(&SHARED, "all-or-none", &one_by_one)["hash"], before["hash"]);
}

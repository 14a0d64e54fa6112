//! Tests of `bendylights drag`.

use serde_json::{Value, json};

use crate::program::{Folder, json_for, refused};

/// Pixels in the demo's own picture: the shadow of the blue vase's neck on the table, and a lit point of the
/// table.
const SHADOW: [f64; 2] = [430.5, 265.5];
const LIT: [f64; 2] = [430.5, 310.5];

fn drags(list: &Value) -> Vec<Value> {
    serde_json::from_value(json_for(&["drag", "demo:vases", "-"], &list.to_string())).expect("an array")
}

fn asked(kind: &str, from: [f64; 2], to: [f64; 2]) -> Value {
    json!({"light": 0, "kind": kind, "size": [640, 360], "from": from, "to": to})
}

/// A dragged shadow reaches its target: `eval` finds M' on the light path of the caster, behind it.
///
/// Rules: DRAG-1, DRAG-3
#[test]
fn a_shadow_goes_where_it_is_put() {
    let mut bend = asked("shadow", SHADOW, LIT);
    bend["points"] = json!([2, 3, 4]);
    for (drag, moves) in [(asked("shadow", SHADOW, LIT), "transform"), (bend, "points")] {
        let answer = &drags(&json!([drag]))[0];
        assert_eq!(
            (&answer["status"], &answer["limit"], &answer["reason"]),
            (&json!("landed"), &Value::Null, &Value::Null),
            "{answer}"
        );
        assert!(answer["residualPx"].as_f64().expect("pixels") < 0.5);
        let folder = Folder::new();
        let light = folder.file("light.json", answer["light"].to_string());
        let points = json!([answer["pivotWorld"], answer["toWorld"]]).to_string();
        let places = json_for(&["eval", &light, "--scene", "demo:vases", "--precision", "0"], &points);
        let number = |place: usize, field: &str| places[place][field].as_f64().expect("a number");
        for across in ["v", "w"] {
            assert!((number(0, across) - number(1, across)).abs() < 1e-6, "{places}");
        }
        assert!(number(0, "t") < number(1, "t"), "{places}");
        assert_eq!(places[1]["visible"], json!(false), "{places}");
        let before: Value = drags(&json!([asked("hotspot", LIT, [1e9, 0.0])]))[0]["light"].clone();
        for kept in ["transform", "points", "up", "radii"] {
            assert_eq!(before[kept] == answer["light"][kept], kept != moves, "{kept}");
        }
    }
}

/// Rules: DRAG-2
#[test]
fn the_order_of_drags_does_not_matter() {
    let [a, b] = [asked("shadow", SHADOW, LIT), asked("hotspot", LIT, SHADOW)];
    let without_seconds = |mut answers: Vec<Value>| {
        for answer in &mut answers {
            answer["seconds"] = Value::Null;
        }
        answers
    };
    let forth = without_seconds(drags(&json!([a, b])));
    let mut back = without_seconds(drags(&json!([b, a])));
    back.reverse();
    assert_eq!(forth, back);
}

/// Rules: DRAG-4
#[test]
fn an_impossible_drag_is_refused_with_a_reason() {
    let reason = |change: &dyn Fn(&mut Value)| {
        let mut drag = asked("shadow", SHADOW, LIT);
        change(&mut drag);
        let answer = drags(&json!([drag]))[0].clone();
        assert_eq!((&answer["status"], &answer["residualPx"]), (&json!("refused"), &Value::Null));
        answer["reason"].clone()
    };
    assert_eq!(reason(&|drag| drag["points"] = json!([0])), "noSuchPoint");
    assert_eq!(reason(&|drag| drag["from"] = json!([-1e6, 0])), "nothingAtStart");
    assert_eq!(reason(&|drag| drag["to"] = json!([-1e6, 0])), "nothingAtEnd");
    assert_eq!(reason(&|drag| drag["from"] = json!(LIT)), "noShadow");
}

#[test]
fn bad_drags_get_one_sentence() {
    let folder = Folder::new();
    let refused = |list: Value, words: &str| {
        let file = folder.file("drags.json", list.to_string());
        assert_eq!(refused(&["drag", "demo:vases", &file], "", &[words]).stdout, "");
    };
    let with = |field: &str, value: Value| {
        let mut drag = asked("shadow", SHADOW, LIT);
        drag[field] = value;
        json!([drag])
    };
    refused(with("light", json!("rim")), "no light `rim`: choose one of `key`");
    refused(with("light", json!(7)), "no light `7`");
    refused(with("camera", json!("door")), "no camera `door`");
    refused(with("size", json!([0, 10])), "drag 0: `size` must be two whole numbers from 1 to 8192");
    refused(with("kind", json!("glow")), "`glow` is not");
    refused(with("pull", json!(1)), "there is no field `pull`");
    refused(json!({}), "drags.json");
}

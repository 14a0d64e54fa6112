//! Tests of refused commands, mainly of `set`. The messages quote little of the input.

use document::{Command, CommandContext, Document, execute_command};
use protocol::{ErrorCode, Refused};
use serde_json::{Value, json};

fn command(json: Value) -> Result<Command, Refused> {
    serde_json::from_value::<protocol::Command>(json).expect("the right shape").try_into()
}

fn set(target: &str, value: &Value) -> Result<Command, Refused> {
    command(json!({"type": "set", "target": target, "value": value}))
}

fn refusal(target: &str, value: &Value) -> String {
    set(target, value).expect_err(target).to_string()
}

/// Rules: CMD-8, CMD-10
#[test]
fn a_value_of_another_type_is_told_what_the_parameter_takes() {
    for (target, value, takes) in [
        ("/lights/1/coneAngle", json!("x"), "a number"),
        ("/lights/1/coneAngle", json!(null), "a number"),
        ("/lights/1/range", json!([]), "a number or null"),
        ("/lights/1/enabled", json!(1), "true or false"),
        ("/lights/1/color", json!([1, 2]), "three numbers [r, g, b]"),
        ("/lights/1/up", json!([1, 2, 3, 4]), "three numbers [x, y, z]"),
        ("/lights/1/rotation", json!([1, 2, 3]), "four numbers [x, y, z, w]"),
        ("/lights/1/endMode", json!("x"), "\"cut\" or \"extend\""),
        ("/lights/1/name", json!(1), "text"),
        ("/lights/1/points/2/radius", json!({}), "a number"),
        ("/cameras/2/rotation", json!(3), "four numbers [x, y, z, w]"),
        ("/cameras/2/name", json!({}), "text"),
    ] {
        let name = target.rsplit('/').next().expect("a name");
        let expected = format!("`{target}` cannot be set: `{name}` must be {takes}");
        assert_eq!(refusal(target, &value), expected, "{value}");
    }
    let projection = refusal("/cameras/2/projection", &json!({"perspective": {"yfov": 1}}));
    assert!(projection.contains("`projection` must be {\"perspective\""), "{projection}");
    set("/lights/1/range", &json!(null)).expect("endless");
    set("/cameras/2/projection", &json!({"perspective": {"yfov": 1, "znear": 0.1}})).expect("a projection");
}

/// Only drags of features solve for radii.
///
/// Rules: CMD-14
#[test]
fn the_radii_of_a_dragged_point_are_kept_or_follow() {
    let dragged = |radii: &str| {
        command(json!({"type": "dragPoint", "light": 1, "point": 2, "position": [0, 0, 0], "radii": radii}))
    };
    for (radii, follow) in [("keep", false), ("follow", true)] {
        let Ok(Command::DragPoint { radii_follow, .. }) = dragged(radii) else { panic!("{radii}") };
        assert_eq!(radii_follow, follow);
    }
    let refused = dragged("solve").expect_err("nothing is solved");
    assert_eq!(refused.code(), ErrorCode::BadMessage);
    assert!(refused.to_string().contains("\"keep\" or \"follow\""), "{refused}");
}

/// A refusal is stored as the result of its operation, so it must not hold a long input.
///
/// Rules: CMD-10
#[test]
fn no_refusal_repeats_a_long_input() {
    let long = "é".repeat(1 << 20);
    for (target, value) in [
        (long.clone(), json!(1)),
        (format!("/{long}/1/coneAngle"), json!(1)),
        (format!("/lights/{long}/coneAngle"), json!(1)),
        (format!("/lights/1/{long}"), json!(1)),
        (format!("/lights/1/points/2/{long}"), json!(1)),
        (format!("/lights/1/points/{long}/radius"), json!(1)),
        (format!("/cameras/1/{long}"), json!(1)),
        ("/lights/1/coneAngle".into(), json!(long)),
        ("/lights/1/endMode".into(), json!(long)),
        ("/lights/1/up".into(), json!({ (&*long): 1 })),
        ("/lights/1/points/2/radius".into(), json!([long])),
        ("/cameras/1/translation".into(), json!(long)),
        ("/cameras/1/projection".into(), json!(long)),
        ("/cameras/1/projection".into(), json!({"perspective": { (&*long): 1 }})),
    ] {
        let said = refusal(&target, &value);
        assert!(said.len() < 1_000, "{} bytes: {}", said.len(), said.chars().take(200).collect::<String>());
        assert!(target.len() < 100 || said.contains("é…"), "{said}");
    }
    assert!(refusal("/lights/1/gobo", &json!(1)).contains("there is no parameter `gobo`, only `name`"));
}

/// Earlier clients know one code for a long name, whatever the command.
///
/// Rules: CMD-9
#[test]
fn a_name_that_is_too_long_is_told_so_alike_by_all_commands() {
    let mut document = Document::default();
    let mut edit = |json: Value| {
        let edited = command(json)
            .and_then(|command| Ok(execute_command(&document, &command, CommandContext::default())?.document));
        edited.map(|after| document = after).map_err(|error| (error.code(), error.to_string()))
    };
    let camera = |name: &str| {
        json!({"name": name, "translation": [0, 0, 0], "rotation": [0, 0, 0, 1],
            "projection": {"perspective": {"yfov": 1, "znear": 0.1}}})
    };
    edit(json!({"type": "addLight", "light": {"type": "spot"}})).expect("a light");
    edit(json!({"type": "addCamera", "camera": camera("eye")})).expect("a camera");
    let long = "n".repeat(257);
    for command in [
        json!({"type": "addLight", "light": {"type": "spot", "name": long}}),
        json!({"type": "setLight", "light": 1, "parameter": {"name": long}}),
        json!({"type": "set", "target": "/lights/1/name", "value": long}),
        json!({"type": "addCamera", "camera": camera(&long)}),
        json!({"type": "setCamera", "camera": 2, "parameter": {"name": long}}),
        json!({"type": "set", "target": "/cameras/2/name", "value": long}),
    ] {
        let (code, said) = edit(command.clone()).expect_err("too long");
        assert_eq!(code, ErrorCode::TooMany, "{command}");
        assert!(said.ends_with("`name` has more than 256 bytes: shorten it"), "{command}: {said}");
        assert!(said.len() < 200, "{said}");
    }
    edit(json!({"type": "set", "target": "/lights/1/name", "value": "n".repeat(256)})).expect("not too long");
}

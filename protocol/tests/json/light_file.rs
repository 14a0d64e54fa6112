//! Tests of light files: their values, exact round trips and refusals.

use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, CONE_ANGLE, CONE_SOFTNESS, DECAY, DIRECTION, END_MODE, FRAME, INTENSITY, LIGHT_LINK, NAME, RADIAL_FALLOFF,
    RANGE, SHADOW_LINK, TRANSLATION, UP, WIDTH,
};
use light::{Decay, DirectionMode, EndMode, FrameMode, Light, Links, ParameterOwner, PeriodicCurve, Transform};
use proptest::prelude::*;
use protocol::{light_file, point_file};

const FULL: &str = r#"{"type": "bendy", "name": "key",
     "transform": {"translation": [0,4,0], "rotation": [0,0,0,1], "scale": 1},
     "points": [[0,0,0],[0,0,-1],[0,0,-2]], "radii": [0.1,0.4,0.8],
     "colors": [[1,1,1],[1,1,1],[1,1,1]], "intensities": [1,1,1], "up": [0,1,0], "coneAngle": 25, "coneSoftness": 0.2,
     "frame": "rotationMinimizing", "direction": "tube", "endMode": "cut", "decay": "none"}"#;
const SHORT: &str = r#"{"type": "bendy", "points": [[0,0,0],[0,0,-1],[0,0,-2]], "radii": [0.1,0.4,0.8]}"#;

fn one(text: &str) -> Light {
    let mut lights = light_file::parse(text).expect("a valid light");
    assert_eq!(lights.len(), 1);
    lights.remove(0).light().clone()
}

#[test]
fn everything_but_type_points_and_radii_has_its_documented_default() {
    let expected = one(FULL).with_transform(Transform::default()).with(NAME, String::new());
    assert_eq!(one(SHORT), expected);
    assert_eq!(one(r#"{"type": "spot"}"#), Light::spot());
}

/// Equal sets of links are one value in every notation, and the set of all nodes is the default.
///
/// Rules: LINK-4
#[test]
fn links_are_sets() {
    let links = |json: &str| one(&format!(r#"{{"type": "spot", "lightLink": {json}, "shadowLink": null}}"#));
    let list = |paths: &[&str]| paths.iter().map(|path| String::from(*path)).collect::<Vec<_>>();
    let some = Light::spot().with(LIGHT_LINK, Links::new(list(&["a/b", "c"]), list(&["d#2"])));
    assert_eq!(links(r#"{"include": ["c", "a/b", "c"], "exclude": ["d#2"]}"#), some);
    for all in ["null", "{}", r#"{"include": []}"#, r#"{"exclude": [], "include": []}"#] {
        assert_eq!(links(all), Light::spot());
    }
    let written = |light: &Light| serde_json::to_value(protocol::Light::from(light)).expect("JSON");
    let some = written(&some.with(SHADOW_LINK, Links::new(Vec::new(), list(&["e"]))));
    assert_eq!(some["lightLink"], serde_json::json!({"include": ["a/b", "c"], "exclude": ["d#2"]}));
    assert_eq!(some["shadowLink"], serde_json::json!({"exclude": ["e"]}));
    assert_eq!(written(&Light::spot()).get("lightLink"), None);
    let refused = refusal(r#"{"type": "spot", "lightLink": {"only": ["a"]}}"#);
    assert_eq!(refused, "lightLink.only: there is no field `only`, only `include` or `exclude`");
}

/// An empty list is no curve, which is the default.
///
/// Rules: CURVE-1
#[test]
fn curves_over_an_angle_are_lists_of_pairs() {
    let light = |json: &str| one(&format!(r#"{{"type": "spot", "radialFalloff": {json}}}"#));
    for none in ["null", "[]"] {
        assert_eq!(light(none), Light::spot());
    }
    let some = light("[[0, 1], [90.5, 0.25]]");
    assert_eq!(some, Light::spot().with(RADIAL_FALLOFF, PeriodicCurve::new(vec![[0.0, 1.0], [90.5, 0.25]])));
    let written = serde_json::to_value(protocol::Light::from(&some)).expect("JSON");
    assert_eq!(written["radialFalloff"], serde_json::json!([[0.0, 1.0], [90.5, 0.25]]));
    let refused = refusal(r#"{"type": "spot", "radialFalloff": [[0, 1], [90]]}"#);
    assert_eq!(refused, "radialFalloff[1]: has 1 values, where an array of 2 should be");
}

#[test]
fn every_field_is_read() {
    let text = r#"{"type": "bendy", "name": "rim", "transform": {"translation": [1,2,3], "rotation": [0,1,0,0],
        "scale": 2}, "points": [[0,0,0],[0,0,-1],[0,1,-2]], "radii": [0,0.1,0.2], "colors": [[1,0,0],[0,1,0],[0,0,1]],
        "intensities": [3,2,1], "up": [1,0,0], "coneAngle": 30, "coneSoftness": 0.5, "frame": "up",
        "direction": "path", "endMode": "extend", "decay": "linear"}"#;
    let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.0, 1.0, -2.0)];
    let colors = [DVec3::X, DVec3::Y, DVec3::Z];
    let light = Light::bendy(points, vec![0.0, 0.1, 0.2])
        .with_transform(Transform {
            translation: DVec3::new(1.0, 2.0, 3.0),
            rotation: DQuat::from_xyzw(0.0, 1.0, 0.0, 0.0),
            scale: 2.0,
        })
        .map_points(|i, point| (point.color, point.intensity) = (colors[i], 3.0 - i as f64))
        .with(UP, DVec3::X)
        .with(CONE_ANGLE, 30.0)
        .with(CONE_SOFTNESS, 0.5)
        .with(FRAME, FrameMode::Up)
        .with(DIRECTION, DirectionMode::Path)
        .with(END_MODE, EndMode::Extend)
        .with(DECAY, Decay::Linear);
    assert_eq!(one(text), light.with(NAME, "rim".into()));

    let text = r#"{"type": "spot", "name": "lamp", "transform": {"translation": [1,2,3]}, "color": [1,0.5,0.25],
        "intensity": 40, "coneAngle": 35, "coneSoftness": 0.1, "range": 12, "decay": "none"}"#;
    let light = Light::spot()
        .with(TRANSLATION, DVec3::new(1.0, 2.0, 3.0))
        .with(COLOR, DVec3::new(1.0, 0.5, 0.25))
        .with(INTENSITY, 40.0)
        .with(CONE_ANGLE, 35.0)
        .with(CONE_SOFTNESS, 0.1)
        .with(RANGE, Some(12.0))
        .with(DECAY, Decay::None);
    assert_eq!(one(text), light.with(NAME, "lamp".into()));
}

/// Rules: CMD-11
#[test]
fn lists_that_have_a_default_may_be_null() {
    let of_nulls = SHORT.replacen('}', r#", "colors": null, "intensities": null}"#, 1);
    assert_eq!(one(&of_nulls), one(SHORT));
    let command = |light: &str| {
        let text = format!(r#"{{"type": "addLight", "light": {light}}}"#);
        let wire: protocol::Command = protocol::parse_body(&text).expect("a light");
        document::Command::try_from(wire).expect("a valid light")
    };
    assert_eq!(command(&of_nulls), command(SHORT));
    for (field, expected) in [
        ("radii", "radii: is null, where an array should be"),
        ("points", "points: is null, where an array should be"),
        ("name", "name: is null, where a text should be"),
        ("coneAngle", "coneAngle: is null, where a number should be"),
        ("transform", "transform: is null, where an object should be"),
    ] {
        let mut light: serde_json::Value = serde_json::from_str(SHORT).expect("JSON");
        light[field] = serde_json::Value::Null;
        assert_eq!(refusal(&light.to_string()), expected);
    }
    let twice = SHORT.replacen('}', r#", "colors": null, "colors": null}"#, 1);
    assert_eq!(refusal(&twice), "the field `colors` is there twice");
}

/// Names are cut like those of glTF files, at a character boundary.
#[test]
fn a_long_name_is_cut() {
    for (name, cut) in [
        ("n".repeat(256), "n".repeat(256)),
        ("n".repeat(257), "n".repeat(256)),
        (format!("n{}", "é".repeat(128)), format!("n{}", "é".repeat(127))),
        ("\u{1f4a1}".repeat(1 << 16), "\u{1f4a1}".repeat(64)),
    ] {
        let light = one(&SHORT.replacen('}', &format!(", \"name\": \"{name}\"}}"), 1));
        assert_eq!(light.name(), cut);
    }
}

#[test]
fn a_file_holds_one_light_or_an_array() {
    assert_eq!(light_file::parse(&format!("[{FULL}, {{\"type\": \"spot\"}}]")).expect("two lights").len(), 2);
    assert_eq!(light_file::parse(" [] ").expect("no lights"), []);
}

#[test]
fn json_has_a_line_a_field() {
    let json = light_file::to_json(&one(SHORT));
    let begins = r#"{
  "type": "bendy",
  "name": "",
  "transform": {"translation": [0.0, 0.0, 0.0], "rotation": [0.0, 0.0, 0.0, 1.0], "scale": 1.0},
  "points": [[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 0.0, -2.0]],
  "radii": [0.1, 0.4, 0.8],
  "colors": [[1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, 1.0, 1.0]],
  "intensities": [1.0, 1.0, 1.0],
  "enabled": true,
  "color": [1.0, 1.0, 1.0],
"#;
    assert!(json.starts_with(begins), "{json}");
    let lines: Vec<_> = json.lines().collect();
    for field in ["exposure", "coneAngle", "frame", "up"] {
        assert!(lines.iter().any(|line| line.starts_with(&format!("  \"{field}\": "))), "{json}");
    }
    assert!(lines.last() == Some(&"}") && lines.iter().filter(|line| line.ends_with(',')).count() == lines.len() - 3);
}

proptest! {
    #[test]
    fn a_light_comes_back_bit_for_bit(
        translation in prop::array::uniform3(-1e300..1e300f64),
        rotation in prop::array::uniform4(0.1..1.0f64),
        numbers in prop::array::uniform5(0.0..1.0f64),
        name in ".*",
        extra in 0usize..4,
    ) {
        let [a, b, c, d, e] = numbers;
        let points = (0..3 + extra).map(|i| DVec3::new(a, b, -1.0 - c) * i as f64).collect();
        let light = Light::bendy(points, vec![d; 3 + extra]).with_transform(Transform {
                translation: translation.into(),
                rotation: DQuat::from_array(rotation).normalize(),
                scale: d + 0.5,
            }).with(CONE_ANGLE, 1.0 + 80.0 * e).with(CONE_SOFTNESS, a).with(DECAY, if b < 0.5 { Decay::Linear } else { Decay::InverseSquare }).map_points(|i, point| point.intensity = c * i as f64);
        let light = light.with(NAME, name);
        prop_assert_eq!(&one(&light_file::to_json(&light)), &light);

        let color = glam::DVec3::from(translation).abs();
        let spot = Light::spot().with(COLOR, color).with(INTENSITY, e).with(RANGE, Some(a + 1.0));
        let spot = spot.with(NAME, "s".into());
        prop_assert_eq!(&one(&light_file::to_json(&spot)), &spot);
        let omni = Light::omni().with(COLOR, color).with(RANGE, Some(a + 1.0));
        prop_assert_eq!(&one(&light_file::to_json(&omni)), &omni);
        let directional = Light::directional().with(INTENSITY, e).with(WIDTH, Some(a + 1.0));
        prop_assert_eq!(&one(&light_file::to_json(&directional)), &directional);
    }

    #[test]
    fn a_point_comes_back_bit_for_bit(bits in any::<[u64; 3]>()) {
        let point = bits.map(f64::from_bits);
        prop_assume!(point.iter().all(|x| x.is_finite()));
        let text = serde_json::to_string(&[point]).expect("numbers");
        let back = point_file::parse(&text).expect("a point file");
        prop_assert_eq!(back[0].position.to_array().map(f64::to_bits), bits);
    }

    /// No text makes the parser panic. Every light that it accepts can be written and parsed again.
    #[test]
    fn no_text_panics(text in r#"[\[\]{}",:0-9a-z.\-]{0,40}"#, at in 0..SHORT.len(), byte in any::<char>()) {
        let _ = point_file::parse(&text);
        let _ = light_file::parse(&text);
        let mut spoilt: Vec<char> = SHORT.chars().collect();
        spoilt[at] = byte;
        if let Ok(lights) = light_file::parse(&spoilt.into_iter().collect::<String>()) {
            for light in lights {
                prop_assert_eq!(&one(&light_file::to_json(light.light())), light.light());
            }
        }
    }
}

/// Returns the message with which `text` is refused.
fn refusal(text: &str) -> String {
    light_file::parse(text).expect_err("a bad light").to_string()
}

/// Returns the message for [`SHORT`] with `from` replaced by `to`.
fn spoilt(from: &str, to: &str) -> String {
    assert!(SHORT.contains(from));
    refusal(&SHORT.replacen(from, to, 1))
}

#[test]
fn broken_json_is_refused_with_its_line_and_column() {
    for (said, problem) in [
        (refusal(""), "it ends where a value should begin (line 1, character 0)"),
        (refusal("{\n\"type\""), "it ends before what began is closed (line 2, character 6)"),
        (spoilt("0.1", "NaN"), "there is no value where one should be (line 1, character 68)"),
        (spoilt("0.1", "1e999"), "a number is out of range (line 1, character 72)"),
        (refusal(&format!("{SHORT} {SHORT}")), "something follows where it should end (line 1, character 82)"),
        (refusal("[{\"type\": \"spot\"},\n]"), "a comma stands before the end (line 2, character 1)"),
    ] {
        let hint = "(numbers must be finite; JSON has no NaN or Infinity)";
        assert_eq!(said, format!("not valid JSON: {problem} {hint}"));
    }
}

/// Returns the fields of a light by the table, in the form of messages. The lists of control points follow the
/// transform.
fn fields(owner: ParameterOwner) -> String {
    let mut names = vec!["type"];
    for row in light::parameters_of(owner) {
        let name = row.path.split('.').next().expect("a path");
        if !names.contains(&name) {
            names.push(name);
            let points = light::parameters_of(ParameterOwner::Point).iter().map(|row| row.path);
            names.extend(points.filter(|_| name == "transform" && owner == ParameterOwner::Bendy));
        }
    }
    names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
}

#[test]
fn a_wrong_shape_is_refused_with_its_place() {
    let (bendy_fields, spot_fields) = (fields(ParameterOwner::Bendy), fields(ParameterOwner::Spot));
    let light = "a light: an object with `type`, `points`, `radii` and so on";
    for (said, expected) in [
        (refusal("3"), format!("is the number 3, where {light} should be")),
        (refusal("[3]"), format!("light 0: is the number 3, where {light} should be")),
        (refusal("{}"), "the field `type` is missing".into()),
        (spoilt("bendy", "area"), "type: `area` is not one of `bendy`, `spot`, `omni`, `directional`".into()),
        (spoilt("\"radii\"", "\"radius\""), format!("radius: there is no field `radius`, only {bendy_fields}")),
        (
            refusal("[{\"type\": \"spot\"}, {\"type\": \"spot\", \"radii\": []}]"),
            format!("light 1: radii: there is no field `radii`, only {spot_fields}"),
        ),
        (
            spoilt("}", ", \"transform\": {\"size\": 1}}"),
            "transform.size: there is no field `size`, only `translation`, `rotation`, `scale`".into(),
        ),
        (spoilt(", \"radii\": [0.1,0.4,0.8]", ""), "the field `radii` is missing".into()),
        (spoilt("}", ", \"radii\": [1,1,1]}"), "the field `radii` is there twice".into()),
        (spoilt("0.4", "\"a\""), "radii[1]: is the text \"a\", where a number should be".into()),
        (spoilt("0.4", "null"), "radii[1]: is null, where a number should be".into()),
        (spoilt("[0,0,-1]", "[0,0]"), "points[1]: has 2 values, where an array of 3 should be".into()),
        (spoilt("}", ", \"decay\": \"fast\"}"), "decay: `fast` is not one of `none`, `linear`, `inverseSquare`".into()),
    ] {
        assert_eq!(said, expected);
    }
}

#[test]
fn lights_that_cannot_be_evaluated_are_refused() {
    let bend = |radius: &str| {
        let points = "[[0,0,0],[0,0,-1],[1,0,-1]]";
        format!("{{\"type\": \"bendy\", \"points\": {points}, \"radii\": [{radius},{radius},{radius}]}}")
    };
    assert!(light_file::parse(&bend("0.2")).is_ok(), "the fold below comes from its radius alone");
    for (said, must_name) in [
        (spoilt(",[0,0,-2]", ""), "needs at least 3 control points, this one has 2"),
        (spoilt("0.4", "-0.4"), "-0.4"),
        (spoilt(",0.8", ""), "`radii` has 2 entries for 3 control points"),
        (spoilt("}", ", \"colors\": [[1,1,1]]}"), "`colors` has 1 entries for 3 control points"),
        (spoilt("}", ", \"intensities\": [1]}"), "`intensities` has 1 entries for 3 control points"),
        (refusal(&bend("5")), "the tube folds in segment 0"),
        (refusal(r#"{"type": "spot", "coneAngle": 90}"#), "coneAngle"),
        (refusal(r#"[{"type": "spot"}, {"type": "spot", "coneAngle": 0}]"#), "light 1: "),
    ] {
        assert!(said.contains(must_name), "{said}");
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}

#[test]
fn a_bad_point_file_is_refused_with_its_place() {
    for (text, expected) in [
        ("{}", "is an object, where an array should be"),
        ("[[0,0,0],[0,0]]", "[1]: has 2 values, where an array of 3 should be"),
        ("[[0,\"x\",0]]", "[0][1]: is the text \"x\", where a number should be"),
        // A vector with a number too many or too few is an error of shape that names the field.
        ("[[0, 0, 0], [1, 2, 3, 4]]", "[1]: too many numbers: a pair has 2, a vector 3, a rotation 4"),
        ("[[0, 0, 0], [1, 2]]", "[1]: has 2 values, where an array of 3 should be"),
    ] {
        assert_eq!(point_file::parse(text).expect_err("a bad point file").to_string(), expected, "{text}");
    }
    let surplus = point_file::parse("[[0, 0, 0]] 7").expect_err("a bad point file").to_string();
    assert!(surplus.starts_with("not valid JSON: something follows"), "{surplus}");
}

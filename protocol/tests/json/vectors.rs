//! Tests of `vectors/`: cases that this test generates, and that the page's tests run too. With
//! `BENDYLIGHTS_BLESS=1` the tests write the files anew.

use std::sync::Arc;

use document::{AssetHash, CameraId, CameraParameter, Command, CommandContext, LightPin, SceneContents};
use drag::{DragPin, PinKind, PinTarget};
use glam::{DQuat, DVec3};
use light::parameters::{
    COLOR, CONE_ANGLE, CONE_SOFTNESS, DECAY, DIRECTION, END_MODE, FRAME, INTENSITY, NAME, POINT_COLOR, POINT_INTENSITY,
    POSITION, RADIUS, RANGE, UP,
};
use light::{CheckedLight, Decay, DirectionMode, EndMode, FrameMode, Light, LightId, Tube};
use protocol::{Change, Document, parameter_table};
use scene::{Camera, Projection};
use serde_json::{Value, json};
use stream::{Codec, FrameFlags, FrameHeader, FrameTile};

use crate::assert_committed;

/// Formats one case per line.
fn list(cases: &[Value]) -> String {
    let lines: Vec<_> = cases.iter().map(Value::to_string).collect();
    format!("[\n{}\n]\n", lines.join(",\n"))
}

const BENDY: LightId = LightId(1);
const SPOT: LightId = LightId(2);
const EYE: CameraId = CameraId(3);

fn bendy() -> Light {
    let points = vec![DVec3::ZERO, DVec3::new(0.0, 0.0, -1.0), DVec3::new(0.5, 0.25, -2.0)];
    Light::bendy(points, vec![0.125, 0.25, 0.5]).with(NAME, "key".into())
}

fn spot() -> Light {
    Light::spot().with(NAME, "lamp".into())
}

fn checked(light: Light) -> Arc<CheckedLight> {
    Arc::new(CheckedLight::new(light).expect("a valid light"))
}

fn eye() -> Camera {
    let projection = Projection::Perspective { yfov: 0.75, aspect_ratio: None, znear: 0.125, zfar: None };
    let (translation, rotation) = (DVec3::new(0.0, 1.0, 5.0), DQuat::IDENTITY);
    Camera { name: "eye".into(), translation, rotation, projection }
}

/// Scene with a spotlight.
const ROOM: AssetHash = AssetHash([1; 32]);

fn contents() -> SceneContents {
    SceneContents { lights: vec![checked(spot())], cameras: vec![eye()] }
}

/// Applies `command` to `document` and returns the changes.
fn done(document: &mut document::Document, command: &Command) -> Vec<document::Change> {
    let contents = contents();
    let context = CommandContext { loaded: Some(&contents), ..CommandContext::default() };
    let edited = document::execute_command(document, command, context).expect("a valid command");
    *document = edited.document;
    edited.changes
}

fn edited() -> document::Document {
    let mut document = document::Document::default();
    done(&mut document, &Command::AddLight(checked(bendy())));
    done(&mut document, &Command::AddLight(checked(spot())));
    done(&mut document, &Command::AddCamera(eye()));
    document
}

fn change_case(
    name: &str,
    before: &document::Document,
    changes: &[document::Change],
    after: &document::Document,
) -> Value {
    let changes: Vec<_> = changes.iter().map(Change::from).collect();
    json!({"name": name, "document": Document::from(before), "changes": changes, "after": Document::from(after)})
}

/// Returns the case of the command on [`edited`], and the case of its undo.
fn forward_and_inverse_cases((name, command): &(&str, Command)) -> [Value; 2] {
    let before = edited();
    let mut after = before.clone();
    let changes = done(&mut after, command);
    let inverses = document::Change::inverses(&changes);
    let back = change_case(&format!("{name}, taken back"), &after, &inverses, &before);
    [change_case(name, &before, &changes, &after), back]
}

/// Returns a command for each type of change, and for each kind of addition and removal.
fn commands() -> Vec<(&'static str, Command)> {
    let (vector, rotation) = (DVec3::new(0.5, 0.25, 0.125), DQuat::from_xyzw(0.0, 0.6, 0.0, 0.8));
    let set_light = |light, setting| Command::SetLight { light, setting, ignore_pins: false };
    let set_point = |setting| Command::SetPoint { light: BENDY, point: 1, setting, ignore_pins: false };
    let set_camera = |parameter| Command::SetCamera { camera: EYE, parameter };
    let (position, radius, color, intensity) = (None, None, None, None);
    let orthographic = Projection::Orthographic { ymag: 2.0, aspect_ratio: Some(1.5), znear: 0.5, zfar: 10.0 };
    let (translation, scale) = (Some(vector), Some(2.0));
    let pin =
        |kind, at| Command::AddPin(LightPin { light: BENDY, pin: DragPin { kind, at, caster: None, is_hard: true } });
    vec![
        ("a scene", Command::LoadScene { asset: ROOM, name: "room".into() }),
        ("a light that comes", Command::AddLight(checked(bendy()))),
        ("a light that goes", Command::RemoveLight(BENDY)),
        (
            "a light placed",
            Command::PlaceLight { light: SPOT, translation, rotation: Some(rotation), scale, ignore_pins: false },
        ),
        ("a light's name", set_light(BENDY, NAME.to("rim \u{e9} \"".into()))),
        ("a light's cone angle", set_light(BENDY, CONE_ANGLE.to(30.1))),
        ("a light's softness", set_light(SPOT, CONE_SOFTNESS.to(0.75))),
        ("a light's decay", set_light(SPOT, DECAY.to(Decay::Linear))),
        ("a bendy light's up", set_light(BENDY, UP.to(vector))),
        ("a bendy light's frame", set_light(BENDY, FRAME.to(FrameMode::Up))),
        ("a bendy light's direction", set_light(BENDY, DIRECTION.to(DirectionMode::Path))),
        ("a bendy light's end", set_light(BENDY, END_MODE.to(EndMode::Extend))),
        ("a spotlight's colour", set_light(SPOT, COLOR.to(vector))),
        ("a spotlight's intensity", set_light(SPOT, INTENSITY.to(3.5))),
        ("a spotlight's range", set_light(SPOT, RANGE.to(Some(6.5)))),
        ("a point's position", set_point(POSITION.to(DVec3::new(0.1, 0.2, -1.1)))),
        ("a point's radius", set_point(RADIUS.to(0.3))),
        ("a point's colour", set_point(POINT_COLOR.to(vector))),
        ("a point's intensity", set_point(POINT_INTENSITY.to(3.5))),
        (
            "a point dragged, and radii that follow",
            Command::DragPoint {
                light: BENDY,
                point: 2,
                position: DVec3::NEG_X * 3.0,
                radii_follow: true,
                ignore_pins: false,
            },
        ),
        (
            "a point inserted",
            Command::InsertPoint { light: BENDY, point: 2, position, radius, color, intensity, ignore_pins: false },
        ),
        ("a pin of a point", pin(PinKind::Look, PinTarget::Point(vector))),
        ("a pin of an object", pin(PinKind::Coordinates, PinTarget::Node("vases/blue".into()))),
        ("a camera that comes", Command::AddCamera(eye())),
        ("a camera that goes", Command::RemoveCamera(EYE)),
        ("a camera placed", Command::PlaceCamera { camera: EYE, translation, rotation: Some(rotation) }),
        ("a camera's name", set_camera(CameraParameter::Name("side".into()))),
        ("a camera's projection", set_camera(CameraParameter::Projection(orthographic))),
    ]
}

/// Rules: REC-2, DOC-1, DOC-2
#[test]
fn changes_do_the_same_on_both_sides() {
    let cases: Vec<Value> = commands().iter().flat_map(forward_and_inverse_cases).collect();
    let types = ["scene", "light", "lightParameter", "point", "controlPoints", "camera", "cameraParameter"];
    for name in types {
        let of_type = |case: &Value| case["changes"].as_array().is_some_and(|c| c.iter().any(|c| c["type"] == name));
        assert!(cases.iter().any(of_type), "{name}");
    }
    assert!(cases.iter().all(|case| case["document"] != case["after"]), "each case can fail");
    assert_committed("vectors/changes.json", &list(&cases));
}

/// Evaluates the curve of `light`, of scale 1, at `t`: light-local position, radius, and P'(t).
fn curve_case(light: &Light, t: f64) -> Value {
    let tube = Tube::<f64>::new(light).expect("a valid light");
    let local_per_tube = tube.placement.world_per_tube / light.transform().scale;
    let index = (t.floor() as usize).min(tube.n - 1);
    let (curve, u) = (&tube.segments[index].curve, t - index as f64);
    let [position, tangent] = [curve.position(u), curve.d(u) * 2.0].map(|v| (v * local_per_tube).to_array());
    let radius = curve.radius(u) * local_per_tube;
    json!({"light": protocol::Light::from(light), "t": t, "position": position, "radius": radius, "tangent": tangent})
}

/// Rules: DOC-1
#[test]
fn a_curve_is_the_same_on_both_sides() {
    let demo = assets::demo("vases").expect("the demo scene");
    let key = demo.contents.lights[0].light().clone();
    let points = (0..7).map(|i| DVec3::new(0.25 * f64::from(i * i), 0.5 * f64::from(i), 0.0)).collect();
    let radii = vec![0.0, 0.1, 0.2, 0.15, 0.3, 0.25, 0.4];
    let long = Light::bendy(points, radii).with(NAME, "long".into());
    let mut cases = Vec::new();
    for light in [bendy(), key, long] {
        let segments = (light.points().len() - 2) as f64;
        let places = [0.0, 0.1, 0.5, 1.0, segments - 0.7, segments - 0.25, segments];
        let mut places: Vec<f64> = places.into_iter().filter(|&t| t <= segments).collect();
        places.dedup();
        cases.extend(places.iter().map(|&t| curve_case(&light, t)));
    }
    assert_eq!(cases[0]["position"], json!([0.0, 0.0, 0.0]), "it starts in its first control point");
    assert_committed("vectors/curve.json", &list(&cases));
}

/// Rules: FRAME-1
#[test]
fn a_frame_header_is_the_same_on_both_sides() {
    let tile = FrameTile { x: 1, y: 2, width: 640, height: 360 };
    let header = FrameHeader {
        codec: Codec::Png,
        flags: FrameFlags { is_key: true, is_settled: true, is_last_tile: true },
        view: 0,
        frame: 41,
        log_seq: 1_234_567_890_123,
        camera_revision: 9,
        live_revision: 17,
        samples: 4,
        shadow_map_divisor: 2,
        tile,
        width: 640,
        height: 382,
        wait_us: 1_500,
        render_us: 85_000,
        encode_us: 3_200,
        view_width: 1280,
        view_height: 764,
    };
    let bytes = header.to_bytes();
    assert_eq!(FrameHeader::from_bytes(&bytes).expect("a header"), header);
    let encoded = const_hex::const_encode::<_, false>(&bytes);
    let hex = encoded.as_str();
    let vector = json!({"hex": hex, "header": {
        "codec": "png",
        "key": header.flags.is_key,
        "settle": header.flags.is_settled,
        "lastTile": header.flags.is_last_tile,
        "view": header.view,
        "frame": header.frame,
        "logSeq": header.log_seq,
        "cameraRevision": header.camera_revision,
        "liveRevision": header.live_revision,
        "samples": header.samples,
        "shadowMapDivisor": header.shadow_map_divisor,
        "tile": {"x": tile.x, "y": tile.y, "width": tile.width, "height": tile.height},
        "width": header.width,
        "height": header.height,
        "waitUs": header.wait_us,
        "renderUs": header.render_us,
        "encodeUs": header.encode_us,
        "viewWidth": header.view_width,
        "viewHeight": header.view_height,
    }});
    assert_committed("vectors/frame.json", &format!("{vector:#}\n"));
}

/// Rules: HTTP-19
#[test]
fn the_table_of_parameters_is_the_same_on_both_sides() {
    let rows: Vec<_> = parameter_table().parameters.iter().map(|row| json!(row)).collect();
    assert_committed("vectors/parameters.json", &list(&rows));
}

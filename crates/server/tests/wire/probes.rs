//! Reasons for which a pixel is lit or not, over HTTP and on the socket.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use protocol::{
    ClientMessage, Command, ErrorCode, ProbeAnswer, ProbeCamera, ProbeDisabledBy, ProbeState, Probed, ServerMessage,
    ViewSettings, ViewSource,
};
use serde_json::{Value, json};

use crate::client::{Client, HttpAnswer, make_session, new_session, open_view, post, results_of, state};
use crate::server::{SHARED, ServerDoor};

/// Pixels of the demo's own picture of 640 x 360: the shadow of the blue vase's neck on the table, and a lit point of
/// the table.
const SHADOW: [f64; 2] = [430.5, 265.5];
const LIT: [f64; 2] = [430.5, 310.5];
const SIZE: [u32; 2] = [640, 360];

fn ask(door: &ServerDoor, session: &str, body: &Value) -> HttpAnswer {
    post(door, &format!("/sessions/{session}/probe"), body)
}

fn found(door: &ServerDoor, session: &str, pixel: [f64; 2]) -> Probed {
    let answer = ask(door, session, &json!({"size": SIZE, "pixel": pixel}));
    assert_eq!(answer.status, 200, "{}", answer.text());
    protocol::parse_body(answer.text()).expect("what was found")
}

/// Rules: HTTP-22, PROBE-1, PROBE-2, PROBE-3
#[test]
fn a_program_asks_why_a_pixel_is_lit_or_not() {
    let (door, session) = (&SHARED, "probe-http");
    new_session(door, session);
    let shadow = found(door, session, SHADOW);
    let seen = shadow.seen.as_ref().expect("the table");
    assert_eq!((seen.node.as_str(), seen.material.as_deref()), ("table", Some("table")));
    let key = &shadow.lights[0];
    let caster = key.shadowed_by.as_ref().expect("a caster");
    assert_eq!((key.state, caster.node.as_str(), key.share), (ProbeState::Shadowed, "blue vase", 0.0));
    let lit = found(door, session, LIT);
    assert_eq!((lit.lights[0].state, lit.lights[0].share), (ProbeState::Lit, 1.0));
    assert_eq!(lit.lights[0].shadowed_by, None);

    // By the camera's id, and by the camera itself, which may look elsewhere. Nothing is visible there, which is a
    // valid answer.
    let document = state(door, session)["document"].take();
    let camera = document["cameras"][0].clone();
    for camera in [json!({"id": camera["id"]}), json!({"own": camera["camera"]})] {
        let again = ask(door, session, &json!({"size": SIZE, "pixel": SHADOW, "camera": camera}));
        assert_eq!(protocol::parse_body::<Probed>(again.text()).expect("found"), shadow);
    }
    let mut away = camera["camera"].clone();
    away["translation"] = json!([0.0, 1e4, 0.0]);
    away["rotation"] = json!([0.0, 0.0, 0.0, 1.0]);
    let nothing = ask(door, session, &json!({"size": SIZE, "pixel": SHADOW, "camera": {"own": away}}));
    assert_eq!((nothing.status, nothing.json()), (200, json!({"seen": null, "lights": []})));
    // A session without a scene shows nothing either.
    make_session(door, &json!({"name": "probe-nothing"}));
    assert_eq!(found(door, "probe-nothing", LIT).seen, None);
}

/// Rules: HTTP-22, HTTP-11, PROBE-1
#[test]
fn an_invalid_probe_is_refused_in_a_sentence() {
    let (door, session) = (&SHARED, "main");
    let camera = state(door, session)["document"]["cameras"][0]["camera"].take();
    let mut flat = camera.clone();
    flat["projection"] = json!({"perspective": {"yfov": 0.0, "znear": 0.1}});
    let cases = [
        (json!({"size": SIZE, "pixel": [640, 1]}), 400, "badMessage", "x goes from 0 to less than 640"),
        (json!({"size": SIZE, "pixel": [1, -0.5]}), 400, "badMessage", "y from 0 to less than 360"),
        (json!({"size": SIZE, "pixel": [1e300, 1]}), 400, "badMessage", "is not in a picture of 640x360"),
        (json!({"size": [0, 9], "pixel": [0, 0]}), 400, "badMessage", "no pixels"),
        (json!({"size": [4097, 9], "pixel": [0, 0]}), 413, "tooLarge", "1 to 4096 pixels"),
        (json!({"size": [4_294_967_295_u32, 1], "pixel": [0, 0]}), 413, "tooLarge", "1 to 4096 pixels"),
        (json!({"size": SIZE, "pixel": [1, 1], "camera": {"id": 99}}), 404, "notFound", "camera `99`"),
        (json!({"size": SIZE, "pixel": [1, 1], "camera": {"own": flat}}), 400, "invalidCamera", "camera"),
        (json!({"size": SIZE, "pixel": [null, 1]}), 400, "badMessage", "pixel[0]"),
        (json!({"size": SIZE}), 400, "badMessage", "pixel"),
        (json!({"size": SIZE, "pixel": [1, 1], "light": 1}), 400, "badMessage", "light"),
    ];
    for (body, status, code, says) in cases {
        let answer = ask(door, session, &body);
        assert_eq!(answer.refusal(), (status, code.into()), "{body}: {}", answer.text());
        assert!(answer.text().contains(says), "{body}: {}", answer.text());
    }
    let endless = post(door, "/sessions/main/probe", r#"{"size": [9, 9], "pixel": [1e999, NaN]}"#);
    assert_eq!(endless.refusal(), (400, "badMessage".into()));
    assert_eq!(ask(door, "nobody", &json!({"size": SIZE, "pixel": [1, 1]})).status, 404);
}

fn probe(name: &str, pixel: [f64; 2]) -> ClientMessage {
    ClientMessage::Probe { probe: name.into(), pixel, camera: None, size: None, highlights: false }
}

/// Asks for a pixel of the client's own view, and returns the answer.
async fn probed(client: &mut Client, name: &str, pixel: [f64; 2]) -> ProbeAnswer {
    client.say(&probe(name, pixel)).await;
    answer_to(client, name).await
}

async fn answer_to(client: &mut Client, name: &str) -> ProbeAnswer {
    let answer = |message| match message {
        ServerMessage::Probed(answer) if answer.probe == name => Some(*answer),
        _ => None,
    };
    client.until(answer).await
}

/// Rules: PROBE-5, PROBE-2, SOCK-12
#[tokio::test]
async fn a_client_asks_of_what_it_sees_now() {
    let (door, session) = (&SHARED, "probe-socket");
    new_session(door, session);
    let (mut ada, welcome) = Client::join(door, session, "Ada").await;
    // Without a view the question needs a camera and a size.
    let refused = probed(&mut ada, "too-soon", LIT).await.refused.expect("refused");
    assert_eq!(refused.code, ErrorCode::BadMessage);
    assert!(refused.message.contains("open one"), "{}", refused.message);
    let camera = Some(ProbeCamera::Own(welcome.camera.clone()));
    ada.say(&ClientMessage::Probe { probe: "far".into(), pixel: LIT, camera, size: Some(SIZE), highlights: false })
        .await;
    let far = answer_to(&mut ada, "far").await;

    ada.say(&open_view(ViewSource::Own(welcome.camera), SIZE)).await;
    let own = probed(&mut ada, "own", LIT).await;
    assert_eq!((own.log_seq, own.refused.clone()), (welcome.seq, None));
    let http = found(door, session, LIT);
    assert!(own.found.as_ref() == Some(&http) && far.found.as_ref() == Some(&http), "{own:?}");
    let refused = probed(&mut ada, "off", [640.0, 0.0]).await.refused.expect("refused");
    assert!(refused.message.contains("640x360"), "{}", refused.message);

    // While a light is dragged, its live state is probed.
    let light = http.lights[0].light;
    let (gesture, base_seq) = (String::from("g"), welcome.seq);
    ada.say(&ClientMessage::GestureBegin { gesture: gesture.clone(), light, base_seq }).await;
    let command: Command =
        serde_json::from_value(json!({"type": "placeLight", "light": light, "translation": [40.0, 3.0, 0.0]}))
            .expect("a command");
    ada.say(&ClientMessage::GestureUpdate { gesture: gesture.clone(), update: 1, command }).await;
    let dragged = probed(&mut ada, "dragged", LIT).await;
    assert!(dragged.live_revision > own.live_revision);
    assert_eq!(dragged.found.expect("found").lights[0].state, ProbeState::Outside);
    ada.say(&ClientMessage::GestureCancel { gesture }).await;

    // Another light, shown alone, hides this one, in that view and for its followers.
    let add = json!([{"command": {"type": "addLight", "light": {"type": "omni", "name": "lamp",
        "transform": {"translation": [0.0, 3.0, 0.0]}}}}]);
    let added = results_of(door, session, &add);
    assert_eq!(added[0]["status"], "committed", "{added:?}");
    let lamp = found(door, session, LIT).lights[1].light;
    let settings = ViewSettings { exposure: 0.0, solo: vec![lamp] };
    ada.say(&ClientMessage::SetView { settings, stats: None, camera_revision: 2 }).await;
    let (mut ben, _) = Client::join(door, session, "Ben").await;
    let alone = probed(&mut ada, "alone", LIT).await.found.expect("found");
    ben.say(&open_view(ViewSource::Follow(welcome.client), [9, 9])).await;
    assert_eq!(probed(&mut ben, "followed", LIT).await.found.expect("found"), alone);
    let muted = (ProbeState::Disabled, Some(ProbeDisabledBy::Muted), 0.0);
    assert_eq!((alone.lights[0].state, alone.lights[0].disabled_by, alone.lights[0].share), muted);
    assert_eq!((alone.lights[1].state, alone.lights[1].share), (ProbeState::Lit, 1.0));
    assert_ne!(found(door, session, LIT).lights[0].state, ProbeState::Disabled, "a program sees all");
}

/// A client that asks faster than probes are traced gets an answer to the latest, and waits for no others.
///
/// Rules: PROBE-5
#[tokio::test]
async fn the_latest_of_many_probes_is_answered() {
    const MANY: usize = 2_000;
    let (door, session) = (&SHARED, "probe-many");
    new_session(door, session);
    let (mut ada, welcome) = Client::join(door, session, "Ada").await;
    ada.say(&open_view(ViewSource::Own(welcome.camera), SIZE)).await;
    let began = Instant::now();
    for number in 0..MANY {
        let pixel = [(number % 640) as f64, (number % 360) as f64];
        ada.say(&probe(&number.to_string(), pixel)).await;
    }
    ada.say(&ClientMessage::Ping { sent: 1.0 }).await;
    let (mut answered, mut pinged) = (BTreeMap::new(), None);
    let last = (MANY - 1).to_string();
    while !answered.contains_key(&last) || pinged.is_none() {
        match ada.next().await.expect("the server has closed") {
            ServerMessage::Probed(answer) => {
                let number: usize = answer.probe.parse().expect("a number");
                assert!(answered.values().all(|before| *before < number), "in order");
                answered.insert(answer.probe, number);
            }
            ServerMessage::Pong { .. } => pinged = Some(began.elapsed()),
            _ => {}
        }
    }
    println!("{} of {MANY} answered, the ping after {pinged:?}", answered.len());
    assert!(pinged.is_some_and(|after| after < Duration::from_secs(10)));
    assert!(answered.len() < MANY, "some came in while another was answered");
}

//! Scripts: ids of added objects, outcomes of drags, names as addresses, picture options.

use std::io::{Cursor, Read};

use exr::prelude::{AnyChannels, FlatSamples, Image, Layer, ReadChannels, ReadLayers, read};
use serde_json::{Value, json};

use crate::client::{
    HttpAnswer, ask_with, bearer, get, get_unless, new_session, post, results_of, set as set_command,
    spot as spot_command, state,
};
use crate::server::SHARED;

/// Returns the value percent-encoded for a query, like `curl --data-urlencode`.
fn encoded(value: &Value) -> String {
    let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    text.bytes()
        .map(|byte| if byte.is_ascii_alphanumeric() { char::from(byte).into() } else { format!("%{byte:02X}") })
        .collect()
}

/// Carries out edits in a session of the shared server and returns their results, in order.
fn edited(session: &str, edits: &Value) -> Vec<Value> {
    results_of(&SHARED, session, edits)
}

fn set(target: &str, value: impl Into<Value>) -> Value {
    json!({"command": set_command(target, value)})
}

fn spot(name: &str) -> Value {
    json!({"command": spot_command(name)})
}

fn camera(name: &str) -> Value {
    json!({"name": name, "translation": [0.3, 2.3, 4.5], "rotation": [0, 0, 0, 1],
        "projection": {"perspective": {"yfov": 0.7, "znear": 0.1}}})
}

fn picture(session: &str, query: &str) -> HttpAnswer {
    get(&SHARED, &format!("/sessions/{session}/render?size=64x36{query}"))
}

fn drawn(session: &str, query: &str) -> Vec<u8> {
    let answer = picture(session, query);
    assert_eq!(answer.status, 200, "{query}: {}", answer.text());
    answer.body
}

fn channels(body: &[u8]) -> Image<Layer<AnyChannels<FlatSamples>>> {
    let reader = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    reader.from_buffered(Cursor::new(body)).expect("an EXR")
}

/// Returns the names of an EXR's channels.
fn channel_names(image: &Image<Layer<AnyChannels<FlatSamples>>>) -> Vec<String> {
    image.layer_data.channel_data.list.iter().map(|channel| channel.name.to_string()).collect()
}

/// Rules: REC-8, REC-4
#[test]
fn results_have_the_added_ids_and_the_outcomes_of_drags() {
    new_session(&SHARED, "told");
    let pin = json!({"opId": "pin", "command": {"type": "addPin",
        "pin": {"kind": "lit", "light": 1, "at": [0, 0, 0], "hard": false}}});
    let add_camera = json!({"command": {"type": "addCamera", "camera": camera("wide")}});
    let results = edited("told", &json!([spot("a"), spot("b"), add_camera, pin, set("/lights/a/exposure", 1)]));
    let [a, b, wide, pinned, not] = &results[..] else { panic!("{results:?}") };
    let [a, b] = [a, b].map(|result| result["added"]["lights"][0].as_u64().expect("an id"));
    assert!(a < b);
    let document = state(&SHARED, "told")["document"].take();
    let ids =
        |of: &str| document[of].as_array().expect("a list").iter().map(|one| one["id"].clone()).collect::<Vec<_>>();
    assert_eq!(wide["added"], json!({"cameras": [ids("cameras").last()]}));
    assert_eq!(pinned["added"], json!({"pins": [ids("pins")[0]]}));
    assert_eq!(not.get("added"), None);
    assert_eq!(edited("told", &json!([pin]))[0], *pinned, "the same operation again");
    let loaded = edited("told", &json!([{"command": {"type": "loadScene", "scene": "demo:vases"}}]));
    let document = state(&SHARED, "told")["document"].take();
    let light = &document["lights"][0]["id"];
    assert_eq!(loaded[0]["added"]["lights"][0], *light);

    let view = &document["cameras"][0]["camera"];
    let drag = |to: [f64; 2]| {
        json!({"opId": format!("{to:?}"), "command": {"type": "dragFeature", "light": light, "kind": "hotspot",
            "camera": view, "size": [640, 360], "from": [320.5, 180.5], "to": to}})
    };
    let dragged = edited("told", &json!([drag([340.5, 180.5]), drag([1e9, 0.0])]));
    let outcome = &dragged[0]["outcome"];
    assert_eq!((&outcome["status"], &outcome["solver"]), (&json!("landed"), &json!("picture")));
    assert!(outcome["residualPx"].as_f64().expect("pixels") <= 0.5);
    assert_eq!((dragged[1].get("outcome"), &dragged[1]["code"]), (None, &json!("drag")));
    assert_eq!(edited("told", &json!([drag([340.5, 180.5])]))[0], dragged[0], "the same operation again");
}

/// Rules: CMD-16
#[test]
fn a_name_that_one_alone_has_is_an_address() {
    new_session(&SHARED, "names");
    let results = edited(
        "names",
        &json!([
            spot("twin"),
            spot("twin"),
            spot("left/right~"),
            set("/lights/key/exposure", 1.5),
            set("/lights/left~1right~0/exposure", 2),
            set("/lights/twin/exposure", 1),
            set("/lights/nobody/exposure", 1),
            set("/lights/left~1right~0/points/1/radius", 0.4),
            set("/lights/key/shine", 1)
        ]),
    );
    let codes: Vec<_> = results.iter().map(|result| result["code"].as_str()).collect();
    let refused = [Some("ambiguous"), Some("notFound"), Some("wrongKind"), Some("badMessage")];
    assert_eq!(codes[5..], refused, "{results:?}");
    let twins: Vec<String> = results[..2].iter().map(|result| result["added"]["lights"][0].to_string()).collect();
    let sentence = results[5]["message"].as_str().expect("a sentence");
    assert!(sentence.contains(&twins.join(", ")), "{sentence}");
    // The log has ids, so a light can be renamed later.
    let log = get(&SHARED, "/sessions/names/log?from=5&limit=1").text().to_owned();
    let record: Value = serde_json::from_str(&log).expect("a record");
    assert_eq!(record["action"]["command"], json!({"type": "setLight", "light": 1, "parameter": {"exposure": 1.5}}));
    // An id precedes a name that looks like one.
    edited("names", &json!([spot("1"), set("/lights/1/exposure", 3)]));
    let lights = state(&SHARED, "names")["document"]["lights"].clone();
    assert_eq!(lights[0]["light"]["exposure"], 3.0);
    assert_eq!(picture("names", "&aov=t&light=twin").refusal(), (409, "ambiguous".into()));
    let drags = json!([{"light": "twin", "kind": "hotspot", "size": [64, 36], "from": [1, 1], "to": [2, 2]}]);
    assert_eq!(post(&SHARED, "/sessions/names/drags", &drags).refusal(), (409, "ambiguous".into()));
}

/// Rules: HTTP-29, HTTP-8
#[test]
fn a_picture_is_asked_for_as_it_would_be_after_an_edit() {
    new_session(&SHARED, "wedge");
    edited("wedge", &json!([spot("second")]));
    let seq = || state(&SHARED, "wedge")["seq"].clone();
    let (before, as_it_is) = (seq(), drawn("wedge", ""));
    let brighter = format!("&set={}", encoded(&json!({"/lights/key/exposure": 2, "/lights/second/enabled": false})));
    let wanted = drawn("wedge", &brighter);
    assert!((seq(), drawn("wedge", "")) == (before, as_it_is.clone()), "nobody sees it");
    edited("wedge", &json!([set("/lights/key/exposure", 2), set("/lights/second/enabled", false)]));
    assert!(drawn("wedge", "") == wanted);
    assert!(wanted != as_it_is);
    // Lights chosen by name or id shine as if there were no others.
    edited("wedge", &json!([set("/lights/second/enabled", true)]));
    assert!(drawn("wedge", "&lights=key") == wanted);
    assert_eq!(drawn("wedge", &format!("&lights={}", encoded(&json!(["key", "second"])))), drawn("wedge", ""));
    // A given camera is like one of the document.
    edited("wedge", &json!([{"command": {"type": "addCamera", "camera": camera("wide")}}]));
    let own = format!("&camera={}", encoded(&camera("wide")));
    assert_eq!(drawn("wedge", &own), drawn("wedge", "&camera=wide"));
    assert_ne!(drawn("wedge", &own), drawn("wedge", ""));
    for (query, refusal) in [
        ("&light=key".to_owned(), (400, "badMessage")),
        ("&aov=depth,normal&light=key".to_owned(), (400, "badMessage")),
        ("&aov=t&light=key&lights=second".to_owned(), (400, "badMessage")),
        ("&aov=t,wireframe&format=exr".to_owned(), (400, "badMessage")),
        ("&lights=nobody".to_owned(), (404, "notFound")),
        (format!("&set={}", encoded(&json!({"/lights/key/exposure": "much"}))), (400, "badMessage")),
        (format!("&set={}", encoded(&json!({"/lights/key/radius": -1}))), (400, "badMessage")),
        (format!("&set={}", encoded(&json!("["))), (400, "badMessage")),
        (format!("&camera={}", encoded(&json!({"name": "x"}))), (400, "badMessage")),
    ] {
        let answer = picture("wedge", &query).refusal();
        assert_eq!((answer.0, answer.1.as_str()), refusal, "{query}");
    }
    let large = get(&SHARED, "/sessions/wedge/render?size=4096x4096&aov=all");
    assert_eq!(large.refusal(), (413, "tooLarge".into()));
}

/// Rules: HTTP-30, HTTP-29
#[test]
fn several_files_come_of_one_drawing() {
    new_session(&SHARED, "files");
    edited("files", &json!([spot("second")]));
    let both = picture("files", "&format=png,exr");
    assert_eq!((both.status, both.kind.as_str()), (200, "application/zip"));
    let mut zip = zip::ZipArchive::new(Cursor::new(both.body)).expect("a ZIP");
    let mut file = |name: &str| {
        let mut bytes = Vec::new();
        zip.by_name(name).expect(name).read_to_end(&mut bytes).expect("whole");
        bytes
    };
    assert!(file("beauty.png") == drawn("files", ""));
    assert!(file("picture.exr") == drawn("files", "&format=exr"));
    assert!(drawn("files", "").windows(4).any(|bytes| bytes == b"sRGB"));
    // The color type of a PNG is in its first chunk: 2 without alpha, 6 with it.
    assert_eq!((drawn("files", "")[25], drawn("files", "&background=transparent")[25]), (2, 6));

    let all = channels(&drawn("files", "&aov=all&format=exr"));
    let of_camera = ["A", "B", "G", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z", "R", "Z"];
    let of_light = ["A", "direction.X", "direction.Y", "direction.Z", "t", "v", "visibility", "w"];
    let of_lights = ["key", "second"].iter().flat_map(|light| of_light.map(|name| format!("{light}.{name}")));
    let mut expected: Vec<String> = of_camera.map(str::to_owned).into_iter().chain(of_lights).collect();
    expected.sort();
    assert_eq!(channel_names(&all), expected);
    let state = state(&SHARED, "files");
    let attribute = |key: &str| {
        let value =
            all.layer_data.attributes.other.iter().find(|(name, _)| name.to_string() == format!("bendylights.{key}"));
        let exr::meta::attribute::AttributeValue::Text(text) = value.expect(key).1 else { panic!("{key}") };
        text.to_string()
    };
    assert_eq!(attribute("session"), "files");
    assert_eq!(attribute("sequence"), state["seq"].to_string());
    assert_eq!(attribute("documentHash"), state["hash"]);
    assert_eq!(attribute("scene"), state["document"]["scene"]["asset"]);
    // With a single light its channels need no name.
    let one = channels(&drawn("files", "&aov=t,visibility&light=second&format=exr"));
    assert_eq!(channel_names(&one), ["A", "t", "visibility"]);
    // Beside other quantities of the camera they have a name. Otherwise two alphas would have the same.
    let both = channels(&drawn("files", "&aov=depth,t&light=second&format=exr"));
    assert_eq!(channel_names(&both), ["A", "Z", "second.A", "second.t"]);
}

/// Rules: HTTP-24
#[test]
fn an_answer_that_a_program_has_is_neither_sent_nor_drawn_again() {
    new_session(&SHARED, "tagged");
    let asked = |path: &str, tag: &str| get_unless(&SHARED, &format!("/sessions/tagged{path}"), tag);
    let tag = |answer: &HttpAnswer| answer.headers["etag"].to_str().expect("text").to_owned();
    let render = "/render?size=64x36";
    let (state, shot) = (asked("", "\"\""), asked(render, "\"\""));
    assert_eq!((state.status, shot.status), (200, 200));
    let known = |path: &str, tag: &str| {
        let answer = asked(path, tag);
        assert!(answer.status == 200 || (answer.status, answer.body.len()) == (304, 0));
        answer.status == 304
    };
    assert!(known("", &tag(&state)) && known(render, &tag(&shot)));
    assert!(!known("/render?size=64x35", &tag(&shot)), "another picture");
    edited("tagged", &json!([set("/lights/key/exposure", 2)]));
    assert!(!known("", &tag(&state)) && !known(render, &tag(&shot)));
    // The earlier document is unchanged.
    let was = asked("/render?size=64x36&at=1", "\"\"");
    edited("tagged", &json!([{"undo": "session"}]));
    assert!(!known("", &tag(&state)), "another record");
    assert!(known(render, &tag(&shot)), "the document is what it was");
    assert!(known("/render?size=64x36&at=1", &tag(&was)));
    // A thousand of them are answered in less time than a few that are drawn.
    let timed = |count: usize, tag: &str| {
        let began = std::time::Instant::now();
        (0..count).for_each(|_| drop(asked(render, tag)));
        began.elapsed()
    };
    let (a_hundred, drawn) = (timed(100, &tag(&shot)), timed(20, "\"\""));
    assert!(a_hundred < drawn * 5, "{a_hundred:?} for 100, {drawn:?} for 20 that are drawn");
}

/// Rules: HTTP-11
#[test]
fn a_refusal_for_other_requests_says_when_to_come_again() {
    let answer = post(&SHARED, "/sessions/nowhere/drags", "[]");
    assert!(answer.headers.get("retry-after").is_none());
    let drag = json!({"light": 0, "kind": "hotspot", "size": [64, 36], "from": [1, 1], "to": [2, 2]});
    new_session(&SHARED, "refused");
    let refused = post(&SHARED, "/sessions/refused/drags", &json!(vec![drag; 1_001]));
    assert_eq!(refused.refusal(), (429, "tooMany".into()));
    assert!(refused.headers["retry-after"].to_str().expect("text").parse::<u32>().is_ok());
}

/// Rules: HTTP-31, HTTP-24
#[test]
fn long_answers_are_compressed_for_clients_that_accept_it() {
    new_session(&SHARED, "compressed");
    edited("compressed", &json!([spot("left"), spot("middle"), spot("right")]));
    let bearer = bearer(&SHARED);
    let asked = |path: &str, more: &[(&str, &str)]| {
        ask_with(&SHARED, path, &[&[("authorization", bearer.as_str())], more].concat(), None)
    };
    for path in ["/openapi.json", "/sessions/compressed", "/sessions/compressed/log"] {
        let (plain, small) = (asked(path, &[]), asked(path, &[("accept-encoding", "br, gzip")]));
        assert!(plain.headers.get("content-encoding").is_none() && plain.body.len() > 1_024, "{path}");
        assert_eq!(small.headers["content-encoding"], "gzip", "{path}");
        let mut text = Vec::new();
        flate2::read::GzDecoder::new(&*small.body).read_to_end(&mut text).expect("gzip");
        assert!(text == plain.body && small.body.len() < plain.body.len() / 2, "{path}");
        let Some(tag) = small.headers.get("etag").map(|tag| tag.to_str().expect("text")) else { continue };
        assert!(tag.starts_with("W/\""), "{tag}");
        assert_eq!(asked(path, &[("accept-encoding", "gzip"), ("if-none-match", tag)]).status, 304);
    }
    let picture = asked("/sessions/compressed/render?size=64x36", &[("accept-encoding", "gzip")]);
    assert!(picture.headers.get("content-encoding").is_none());
    assert!(picture.headers["etag"].to_str().is_ok_and(|tag| tag.starts_with('"')));
    let short = asked("/sessions/nobody", &[("accept-encoding", "gzip")]);
    assert!(short.headers.get("content-encoding").is_none());
}
